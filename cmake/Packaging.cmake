# Debian package of the service: `cpack -G DEB` in a build directory. What only the package has is in components that
# `cmake --install` leaves out: it writes below its prefix only.
if(NOT HELP2MAN)
  message(STATUS "Debian package: cannot be made; install help2man")
  return()
endif()

set(man_pages ${PROJECT_BINARY_DIR}/man)
add_custom_command(OUTPUT ${man_pages}.made
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/man_pages.sh $<TARGET_FILE:cornerfix> ${man_pages}
  COMMAND ${CMAKE_COMMAND} -E touch ${man_pages}.made
  DEPENDS cornerfix ${PROJECT_SOURCE_DIR}/scripts/man_pages.sh
  COMMENT "Making man pages from --help" VERBATIM)
add_custom_target(man_pages ALL DEPENDS ${man_pages}.made)

set(deploy ${PROJECT_SOURCE_DIR}/deploy)
install(DIRECTORY ${man_pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT debian EXCLUDE_FROM_ALL)
install(FILES ${deploy}/debian/config.json DESTINATION /etc/cornerfix COMPONENT debian EXCLUDE_FROM_ALL)
install(FILES ${deploy}/systemd/cornerfix.service DESTINATION /lib/systemd/system COMPONENT debian EXCLUDE_FROM_ALL)
install(FILES ${deploy}/debian/copyright ${deploy}/nginx/cornerfix.conf ${deploy}/nginx/cornerfix_upstream.conf
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cornerfix COMPONENT debian EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME cornerfix)
set(CPACK_PACKAGE_CONTACT "Cornerfix maintainers <maintainers@cornerfix.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION "A server finds the pose of robots in stored maps, over HTTP and without an initial pose.
It comes with a command for maps and recorded runs, and with a page that
shows maps and robots.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL service debian)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "adduser, init-system-helpers, libjs-leaflet, libjs-chart.js")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${deploy}/debian/conffiles ${deploy}/debian/postinst ${deploy}/debian/prerm
  ${deploy}/debian/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
