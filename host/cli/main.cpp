#include "cli/program.h"

int main(int argc, char** argv) { return vasamesh::cli::run(argc, argv); }
