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
sources(all core storage api server evaluation cli)

# web --HTTP--> server --> api -----> core;  cli --> server --> storage --> core
# cli, bench, tests --> evaluation --> core
forbid(FILES ${core} PATTERN "${include}(storage|api|server|evaluation|cli)/" REASON "core knows no other module")
forbid(FILES ${core} PATTERN "${include}(nlohmann|simdjson|httplib|sqlite3|SQLiteCpp|spdlog|CLI|prometheus)"
  REASON "core knows nothing of HTTP, JSON, SQL, logging and command lines")
forbid(FILES core/include/*.hpp PATTERN "${include}(opencv2|png|yaml-cpp)"
  REASON "core's headers show Eigen and the standard library only")
forbid(FILES ${storage} PATTERN "${include}(api|server|evaluation|cli)/" REASON "storage knows core only")
forbid(FILES ${storage} PATTERN "${include}(nlohmann|simdjson|httplib)" REASON "storage knows no JSON and no HTTP")
forbid(FILES ${api} PATTERN "${include}(storage|server|evaluation|cli)/" REASON "api knows core only")
forbid(FILES ${api} PATTERN "${include}(httplib|sqlite3|SQLiteCpp)" REASON "api knows no HTTP library and no SQL")
forbid(FILES ${server} PATTERN "${include}(evaluation|cli)/" REASON "the server knows neither scores nor its command line")
forbid(FILES ${evaluation} PATTERN "${include}(storage|api|server|cli)/" REASON "evaluation knows core only")
forbid(FILES ${evaluation} PATTERN "${include}(nlohmann|simdjson|httplib|sqlite3|SQLiteCpp|spdlog|CLI|prometheus)"
  REASON "evaluation knows nothing of HTTP, JSON, SQL, logging and command lines")
forbid(FILES server/localization_service.* PATTERN "${include}(nlohmann|simdjson|httplib|SQLiteCpp)"
  REASON "the use cases know no HTTP, JSON or SQL")

# One door for each third-party header.
forbid(FILES ${all} EXCEPT "^storage/database" PATTERN "${include}sqlite3" REASON "sqlite3.h is for storage/database*.cpp")
forbid(FILES ${all} EXCEPT "^(storage/|cli/bag/sqlite_bag\\.cpp$)" PATTERN "${include}SQLiteCpp"
  REASON "SQLiteCpp is for storage, and for bags that are SQLite files")
forbid(FILES ${all} EXCEPT "^cli/bag/decompress\\.cpp$" PATTERN "${include}(bzlib|lz4frame|zstd)\\.h"
  REASON "bz2, lz4 and zstd are for cli/bag/decompress.cpp")
forbid(FILES ${all} EXCEPT "^(server|cli)/[^/]*\\.cpp$" PATTERN "${include}httplib"
  REASON "httplib.h is for sources of server and cli, never for a header")
forbid(FILES ${all} EXCEPT "^core/src/" PATTERN "${include}opencv2" REASON "OpenCV is for core's sources")
forbid(FILES ${all} EXCEPT "^core/src/pose_graph.cpp$" PATTERN "${include}ceres" REASON "Ceres is for the pose graph")

# The rivals of the benchmarks know core only; what they need of others is behind bench/external.
sources(rivals bench/rivals)
sources(bench bench)
forbid(FILES ${rivals} PATTERN "${include}(storage|api|server|evaluation|cli|bench/(experiments|external))/"
  REASON "the rivals know core only")
forbid(FILES ${bench} EXCEPT "^bench/external/[^/]*\\.cpp$" PATTERN "${include}(opencv2|mrpt)"
  REASON "OpenCV and MRPT are for the sources of bench/external")

# The page: one file talks to the server, one draws.
forbid(FILES web/*.js EXCEPT "api_client\\.js$" PATTERN "(fetch\\(|EventSource|XMLHttpRequest)"
  REASON "api_client.js alone talks to the server")
forbid(FILES web/*.js EXCEPT "map_(view|layers)\\.js$" PATTERN "[^A-Za-z.]L\\."
  REASON "map_view.js and map_layers.js alone know Leaflet")
forbid(FILES web/index.html PATTERN "(src|href)=\"(https?:)?//" REASON "the page loads nothing from elsewhere")

if(broken)
  message(FATAL_ERROR "wrong includes:\n${broken}")
endif()
