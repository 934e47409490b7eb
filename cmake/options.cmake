# Flags of our own code. One arithmetic for all backends: no contraction into fma, no reassociation.
add_library(vasamesh_flags INTERFACE)
target_compile_options(vasamesh_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-pragmas
  -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(VASAMESH_MARCH)
  target_compile_options(vasamesh_flags INTERFACE -march=${VASAMESH_MARCH})
endif()
if(VASAMESH_SANITIZE)
  add_compile_options(-fsanitize=${VASAMESH_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${VASAMESH_SANITIZE})
endif()
