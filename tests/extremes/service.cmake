# The rows that need a server.
if(STIEFEL_SERVICE)
  foreach(form short long)
    add_test(NAME extremes.service.${form}
             COMMAND ${STIEFEL_PYTHON} -m pytest -q -p no:cacheprovider ${CMAKE_CURRENT_LIST_DIR})
    set_tests_properties(extremes.service.${form} PROPERTIES TIMEOUT 1200 ENVIRONMENT
      "${STIEFEL_PYTHON_ENVIRONMENT};STIEFEL_EXTREMES=${form}")
  endforeach()
  set_tests_properties(extremes.service.long PROPERTIES LABELS long RUN_SERIAL ON)
endif()
