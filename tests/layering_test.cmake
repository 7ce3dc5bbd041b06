# Fails on an include that goes against the arrows of docs/architecture.md.
#   cmake -D SOURCE_DIR=... -P layering_test.cmake

set(broken "")

# forbid(REASON reason PATTERN regex FILES glob... [EXCEPT regex]): no line of the files may match.
function(forbid)
  cmake_parse_arguments(ARG "" "REASON;PATTERN;EXCEPT" "FILES" ${ARGN})
  list(TRANSFORM ARG_FILES PREPEND "${SOURCE_DIR}/")
  file(GLOB_RECURSE files RELATIVE "${SOURCE_DIR}" ${ARG_FILES})
  foreach(file IN LISTS files)
    if(ARG_EXCEPT AND file MATCHES "${ARG_EXCEPT}")
      continue()
    endif()
    file(STRINGS "${SOURCE_DIR}/${file}" lines REGEX "${ARG_PATTERN}")
    foreach(line IN LISTS lines)
      string(APPEND broken "${file}: ${line}\n    ${ARG_REASON}\n")
    endforeach()
  endforeach()
  set(broken "${broken}" PARENT_SCOPE)
endfunction()

function(sources out)
  set(globs "")
  foreach(directory IN LISTS ARGN)
    list(APPEND globs "${directory}/*.hpp" "${directory}/*.cpp")
  endforeach()
  set(${out} "${globs}" PARENT_SCOPE)
endfunction()

set(include "^[ \t]*#[ \t]*include[ \t]*[<\"]")
sources(core core)
sources(storage storage)
sources(api api)
sources(server server)
sources(evaluation evaluation)
sources(frames frames)
sources(ros2 ros2)
sources(client clients/cpp)
sources(cli cli)
sources(all core storage api server evaluation frames ros2 clients/cpp cli)

# web --HTTP--> server --> api -----> core;  cli --> server --> storage --> core
# cli, bench, tests --> evaluation --> frames --> core
# cli, bench --> clients/cpp --> evaluation;  clients/cpp --HTTP--> server
# cli --> ros2 --HTTP--> server;  ros2 --> frames
forbid(FILES ${core} PATTERN "${include}(storage|api|server|evaluation|frames|ros2|clients|cli|bench)/" REASON "core knows no other module")
forbid(FILES ${core} PATTERN "${include}(nlohmann|simdjson|httplib|sqlite3|SQLiteCpp|spdlog|CLI|prometheus)"
  REASON "core knows nothing of HTTP, JSON, SQL, logging and command lines")
forbid(FILES core/include/*.hpp PATTERN "${include}(opencv2|png|yaml-cpp)"
  REASON "core's headers show Eigen and the standard library only")
forbid(FILES core/include/*.hpp PATTERN "${include}core/" REASON "installed headers include installed headers only")
sources(users storage api server evaluation frames ros2 clients/cpp cli)
forbid(FILES ${users} PATTERN "${include}core/" REASON "only core, bench and tests may use what is private to core")

# The layers of core/src, from the lowest to the highest, each with the public headers that it implements.
# Settings and answers (localizer_params.hpp, answer.hpp) are below all layers.
set(higher_layers base scan features map matching local_map acceptance search tracking localizer slam assessment)
set(headers_of_scan corners laser_scan)
set(headers_of_map map_image mapper)
set(headers_of_search localization_map map_sketch map_source)
set(headers_of_localizer localizer)
set(headers_of_slam slam)
set(headers_of_assessment localizability cornerfix)
while(higher_layers)
  list(POP_FRONT higher_layers layer)
  sources(layer_files core/src/${layer})
  foreach(higher IN LISTS higher_layers)
    forbid(FILES ${layer_files} PATTERN "${include}core/src/${higher}/" REASON "${layer} is a lower layer than ${higher}")
    foreach(header IN LISTS headers_of_${higher})
      forbid(FILES ${layer_files} PATTERN "${include}cornerfix/${header}\\.hpp" REASON "${layer} is a lower layer than ${higher}")
    endforeach()
  endforeach()
endwhile()
forbid(FILES ${core} PATTERN "${include}[a-z_0-9]+\\.hpp\"" REASON "core includes from the repository root")

forbid(FILES ${storage} PATTERN "${include}(api|server|evaluation|frames|ros2|clients|cli|bench)/" REASON "storage knows core only")
forbid(FILES ${storage} PATTERN "${include}(nlohmann|simdjson|httplib)" REASON "storage knows no JSON and no HTTP")
forbid(FILES ${api} PATTERN "${include}(storage|server|evaluation|frames|ros2|clients|cli|bench)/" REASON "api knows core only")
forbid(FILES ${api} PATTERN "${include}(httplib|sqlite3|SQLiteCpp)" REASON "api knows no HTTP library and no SQL")
forbid(FILES ${server} PATTERN "${include}(evaluation|frames|ros2|clients|cli|bench)/" REASON "the server knows neither scores nor its command line")
forbid(FILES ${evaluation} PATTERN "${include}(storage|api|server|ros2|clients|cli|bench)/" REASON "evaluation knows core and frames only")
forbid(FILES ${evaluation} PATTERN "${include}(httplib|sqlite3|spdlog|CLI|prometheus)"
  REASON "evaluation knows nothing of HTTP, logging and command lines")
forbid(FILES ${frames} PATTERN "${include}(storage|api|server|evaluation|ros2|clients|cli|bench)/" REASON "frames knows core only")
forbid(FILES ${client} PATTERN "${include}(storage|api|server|frames|ros2|cli|bench)/"
  REASON "the client knows the server by the HTTP API only")
forbid(FILES ${client} PATTERN "${include}(simdjson|sqlite3|SQLiteCpp|spdlog|CLI|prometheus)"
  REASON "the client knows nothing of SQL, logging and command lines")
forbid(FILES ${ros2} PATTERN "${include}(storage|api|server|evaluation|clients|cli|bench)/"
  REASON "ros2 knows the server by the HTTP API only")
forbid(FILES ${cli} PATTERN "${include}bench/" REASON "the command knows no benchmark")

# Inside evaluation. Each score is defined in metrics; simulation and datasets know none.
sources(datasets evaluation/datasets)
sources(metrics evaluation/metrics)
sources(simulation evaluation/simulation)
forbid(FILES ${datasets} PATTERN "${include}evaluation/(metrics|simulation)/" REASON "datasets know neither scores nor simulation")
forbid(FILES ${simulation} PATTERN "${include}(evaluation/metrics|frames)/" REASON "simulation knows datasets and core only")
forbid(FILES ${metrics} PATTERN "${include}frames/" REASON "transforms of tf are for the readers of bags")
forbid(FILES ${simulation} PATTERN "${include}nlohmann" REASON "JSON is for logs and reports")
forbid(FILES evaluation/datasets/*.hpp PATTERN "${include}(nlohmann|simdjson|SQLiteCpp|yaml-cpp|zlib|bzlib|lz4|zstd)"
  REASON "libraries that the readers need stay in their sources")
forbid(FILES server/localization_service.* PATTERN "${include}(nlohmann|simdjson|httplib|SQLiteCpp)"
  REASON "the use cases know no HTTP, JSON or SQL")

# One door for each third-party header.
forbid(FILES ${all} EXCEPT "^storage/sqlite/" PATTERN "${include}sqlite3" REASON "sqlite3.h is for storage/sqlite")
forbid(FILES ${all} EXCEPT "^storage/postgresql/" PATTERN "${include}libpq" REASON "libpq is for storage/postgresql")
forbid(FILES ${all} EXCEPT "^(storage/|evaluation/datasets/bag/sqlite_bag\\.cpp$)" PATTERN "${include}SQLiteCpp"
  REASON "SQLiteCpp is for storage, and for bags that are SQLite files")
forbid(FILES ${all} EXCEPT "^evaluation/datasets/bag/decompress\\.cpp$" PATTERN "${include}(bzlib|lz4frame|zstd)\\.h"
  REASON "bz2, lz4 and zstd are for evaluation/datasets/bag/decompress.cpp")
forbid(FILES ${all} EXCEPT "^(server|clients/cpp|ros2)/[^/]*\\.cpp$" PATTERN "${include}httplib"
  REASON "httplib.h is for sources of server, clients/cpp and ros2, never for a header")
forbid(FILES ${all} EXCEPT "^cli/" PATTERN "${include}CLI/" REASON "CLI11 is for the command")
forbid(FILES ${all} EXCEPT "^ros2/" PATTERN "${include}dds/" REASON "Cyclone DDS is for ros2")
forbid(FILES ${all} EXCEPT "^core/src/" PATTERN "${include}opencv2" REASON "OpenCV is for core's sources")
forbid(FILES ${all} EXCEPT "^core/src/slam/pose_graph.cpp$" PATTERN "${include}ceres" REASON "Ceres is for the pose graph")

# The rivals of the benchmarks know core only; what they need of others is behind bench/external.
sources(rivals bench/rivals)
sources(bench bench)
forbid(FILES ${rivals} PATTERN "${include}(storage|api|server|evaluation|clients|cli|bench/(experiments|external))/"
  REASON "the rivals know core only")
forbid(FILES ${bench} PATTERN "${include}(cli|frames|ros2)/" REASON "benchmarks know nothing of the command and of ROS")
forbid(FILES ${bench} EXCEPT "^bench/external/[^/]*\\.cpp$" PATTERN "${include}(opencv2|mrpt)"
  REASON "OpenCV and MRPT are for the sources of bench/external")

# The tests of a module know the module, those below it, and tests/support. The command is for its own tests.
sources(tests tests)
forbid(FILES ${tests} EXCEPT "^tests/unit/cli/" PATTERN "${include}(unit/)?cli/" REASON "the command is for the tests of the command")
sources(core_tests tests/unit/core tests/support)
sources(storage_tests tests/unit/storage)
sources(api_tests tests/unit/api)
sources(server_tests tests/unit/server)
sources(evaluation_tests tests/unit/evaluation)
sources(client_tests tests/unit/clients)
forbid(FILES ${core_tests} PATTERN "${include}(storage|api|server|evaluation|clients|cli|bench)/" REASON "core's tests know core only")
forbid(FILES ${storage_tests} PATTERN "${include}(core|api|server|evaluation|clients|cli|bench)/" REASON "storage's tests know storage and core's headers only")
forbid(FILES ${api_tests} PATTERN "${include}(core|storage|server|evaluation|clients|cli|bench)/" REASON "api's tests know api and core's headers only")
forbid(FILES ${server_tests} PATTERN "${include}(core|evaluation|clients|cli|bench)/" REASON "the server's tests know neither scores nor the command line")
forbid(FILES ${evaluation_tests} PATTERN "${include}(core|storage|api|server|clients|cli|bench)/"
  REASON "the tests of evaluation know evaluation and core's headers only")
forbid(FILES ${client_tests} PATTERN "${include}(core|storage|api|server|cli|bench)/"
  REASON "the tests of the client know the client, evaluation and core's headers only")

# The page: one file talks to the server, one draws.
forbid(FILES web/*.js EXCEPT "api_client\\.js$" PATTERN "(fetch\\(|EventSource|XMLHttpRequest)"
  REASON "api_client.js alone talks to the server")
forbid(FILES web/*.js EXCEPT "map_(view|layers)\\.js$" PATTERN "[^A-Za-z.]L\\."
  REASON "map_view.js and map_layers.js alone know Leaflet")
forbid(FILES web/index.html PATTERN "(src|href)=\"(https?:)?//" REASON "the page loads nothing from elsewhere")

if(broken)
  message(FATAL_ERROR "wrong includes:\n${broken}")
endif()
