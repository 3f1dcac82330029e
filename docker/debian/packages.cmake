# Debian's packages, one for each group of components, by cpack's DEB generator. docker/debian/build
# makes them.
set(debian ${CMAKE_CURRENT_LIST_DIR})
set(papers ${PROJECT_BINARY_DIR}/debian)  # made by docker/debian/build

# Only packages have these: they go to fixed places.
install(FILES ${PROJECT_SOURCE_DIR}/server/aprsimd.service
  DESTINATION /lib/systemd/system COMPONENT service EXCLUDE_FROM_ALL)
install(FILES ${debian}/aprsim.yaml DESTINATION /etc/aprsim COMPONENT service EXCLUDE_FROM_ALL)
install(FILES ${papers}/aprsim.1.gz ${papers}/aprsimd.1.gz ${papers}/aprsim-lab.1.gz
  DESTINATION share/man/man1 COMPONENT service EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME aprsim)
set(CPACK_PACKAGE_VENDOR aprsim)
set(CPACK_PACKAGE_CONTACT "aprsim maintainers <maintainers@users.noreply.github.com>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_APRSIM_PACKAGE_NAME aprsim)
set(CPACK_DEBIAN_APRSIM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_APRSIM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_APRSIM_PACKAGE_DEPENDS "init-system-helpers (>= 1.54), python3")
set(CPACK_DEBIAN_APRSIM_PACKAGE_RECOMMENDS aprsim-web)
set(CPACK_DEBIAN_APRSIM_PACKAGE_SUGGESTS "aprsim-doc, python3-aprsim")
set(CPACK_DEBIAN_APRSIM_DESCRIPTION "stand-in for a robot cell that fills kits
A daemon simulates the physics of the APRS kitting cell in real time: two
arms, a conveyor, grippers, trays, cameras. Controllers drive it as they
drive the cell: by CRCL, Simple Message and Modbus/TCP.")
set(CPACK_DEBIAN_APRSIM_PACKAGE_CONTROL_EXTRA
  ${debian}/postinst ${debian}/prerm ${debian}/postrm ${debian}/conffiles)

set(CPACK_DEBIAN_WEB_PACKAGE_NAME aprsim-web)
set(CPACK_DEBIAN_WEB_PACKAGE_SECTION science)
set(CPACK_DEBIAN_WEB_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_WEB_PACKAGE_DEPENDS aprsim)
set(CPACK_DEBIAN_WEB_DESCRIPTION "web page of the simulated robot cell aprsim
The daemon serves this page: the cell in 3D, its state, and controls.")

set(CPACK_DEBIAN_DOC_PACKAGE_NAME aprsim-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_DESCRIPTION "documents of the simulated robot cell aprsim
The site of all documents, with search. The daemon serves it under /docs.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-aprsim)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${debian}/python/postinst ${debian}/python/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.11), python3-grpcio, python3-numpy, python3-protobuf")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-scipy, python3-yaml")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python package for the simulated robot cell aprsim
It reads and commands a running cell, and offers environments for learning.")

set(CPACK_DEBIAN_CRCL_PACKAGE_NAME libaprsim-crcl-dev)
set(CPACK_DEBIAN_CRCL_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CRCL_PACKAGE_DEPENDS "libprotobuf-dev, libxerces-c-dev")
set(CPACK_DEBIAN_CRCL_DESCRIPTION "C++ library for CRCL, the canonical robot command language
It converts documents between XML, C++ values and protobuf without loss.")

set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME libaprsim-client-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS "libaprsim-crcl-dev, libgrpc++-dev, libmodbus-dev, libssl-dev")
set(CPACK_DEBIAN_CLIENT_DESCRIPTION "C++ library for clients of the simulated robot cell aprsim
It speaks to the cell by CRCL, Modbus, vision lines and gRPC.")

set(CPACK_DEBIAN_DEVICE_PACKAGE_NAME libaprsim-device-dev)
set(CPACK_DEBIAN_DEVICE_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVICE_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DEVICE_DESCRIPTION "C++ interface for devices in the simulated robot cell aprsim
Libraries with devices of your own are built with it and loaded by the cell.")

# Licence and changes of each package.
foreach(group aprsim web doc python crcl client device)
  string(TOUPPER ${group} key)
  set(name ${CPACK_DEBIAN_${key}_PACKAGE_NAME})
  install(FILES ${papers}/copyright ${papers}/changelog.gz
    DESTINATION share/doc/${name} COMPONENT ${group}_papers EXCLUDE_FROM_ALL)
  list(APPEND CPACK_COMPONENTS_ALL ${group}_papers)
endforeach()
list(APPEND CPACK_COMPONENTS_ALL cell service web doc python crcl client device)

include(CPack)
foreach(group aprsim web doc python crcl client device)
  cpack_add_component_group(${group})
  cpack_add_component(${group}_papers GROUP ${group})
  if(NOT group STREQUAL "aprsim")
    cpack_add_component(${group} GROUP ${group})
  endif()
endforeach()
cpack_add_component(cell GROUP aprsim)
cpack_add_component(service GROUP aprsim)
