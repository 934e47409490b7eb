# Installation and the package that find_package(vasamesh) reads.
