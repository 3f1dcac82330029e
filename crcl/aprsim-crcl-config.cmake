# find_package(aprsim-crcl): the target aprsim::crcl, and aprsim::crcl_messages alone.
include(CMakeFindDependencyMacro)
find_dependency(Protobuf)
find_dependency(XercesC)
find_dependency(tl-expected)
include(${CMAKE_CURRENT_LIST_DIR}/aprsim-crcl-targets.cmake)
