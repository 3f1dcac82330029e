# Writes what a build's numbers depend on, where it has changed: of the sources in the list FILES below
# ROOT their digest, and BUILD as it is.
file(STRINGS "${FILES}" names)
set(all "")
foreach(name IN LISTS names)
  file(SHA256 "${ROOT}/${name}" digest)
  string(APPEND all "${name} ${digest}\n")
endforeach()
string(SHA256 world_sha256 "${all}")
set(build "${BUILD}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/build_identity.hpp.in" "${OUTPUT}" @ONLY)
