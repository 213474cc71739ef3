# What `cmake --install build --prefix PREFIX` puts where. Everything finds the rest by its place relative to itself, so the
# whole prefix may be moved.
#   bin/dovetail, bin/dovetail-python     the program; the interpreter with the package on its path
#   share/dovetail/python                 the Python package, with the template of `dovetail new`
#   share/doc/dovetail                    README, licence, documents and examples, laid out as in the source tree
include(GNUInstallDirs)
find_package(Python3 3.11 COMPONENTS Interpreter)
if(NOT Python3_EXECUTABLE)
  set(Python3_EXECUTABLE python3)
endif()

install(TARGETS dovetail)

set(package ${CMAKE_INSTALL_DATADIR}/dovetail/python)
file(RELATIVE_PATH PACKAGE_FROM_PROGRAM ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/dovetail/python)
configure_file(scripts/dovetail-python.in generated/dovetail-python @ONLY)
install(PROGRAMS ${PROJECT_BINARY_DIR}/generated/dovetail-python DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY python/dovetail DESTINATION ${package} PATTERN __pycache__ EXCLUDE)

set(documents ${CMAKE_INSTALL_DATADIR}/doc/dovetail)
install(FILES README.md LICENSE CITATION.cff CHANGELOG.md CONTRIBUTING.md DESTINATION ${documents})
install(DIRECTORY docs DESTINATION ${documents})
install(DIRECTORY inputs DESTINATION ${documents} FILES_MATCHING PATTERN "*.py" PATTERN "*.toml" PATTERN "*.md"
        PATTERN __pycache__ EXCLUDE PATTERN out EXCLUDE)
