# End-to-end tests: scripts that run the real programs, and small programs for what scripts cannot do.
foreach(program compare crowd exact fake_tev false_daemon garble golden hostile mean moves notified picture port same_channels viewer)
  add_executable(e2e_${program} e2e/${program}.c)
endforeach()
foreach(program crowd false_daemon garble hostile moves viewer)
  target_link_libraries(e2e_${program} PRIVATE protocol m)
endforeach()
target_link_libraries(e2e_garble PRIVATE PkgConfig::OPENSSL)
foreach(program compare mean picture same_channels)
  target_link_libraries(e2e_${program} PRIVATE renderer m)
endforeach()
target_link_libraries(e2e_exact PRIVATE protocol renderer m)
target_link_libraries(e2e_golden PRIVATE daemon)

foreach(name access attention bad_input client compare disk exact files hostile libraries move options record saves shutdown steer streams tev
        tracker until views virtual)
  add_test(NAME e2e_${name} COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/e2e/${name}.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
  set_tests_properties(e2e_${name} PROPERTIES LABELS "e2e" SKIP_RETURN_CODE 77)
endforeach()
foreach(name crowd garble tls web)
  add_test(NAME e2e_${name} COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/e2e/${name}.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
  set_tests_properties(e2e_${name} PROPERTIES LABELS "e2e" SKIP_RETURN_CODE 77)
endforeach()
# Tests with clients and threads at once, which the thread sanitizer runs too.
set_tests_properties(e2e_attention e2e_crowd e2e_hostile e2e_move e2e_record e2e_shutdown e2e_steer e2e_tev e2e_views e2e_virtual e2e_web PROPERTIES LABELS "e2e;threads")

# What a new user types first, real scenes, and many small ones. They take long, so they run only in one build.
if(NOT SANITIZE)
  foreach(name cases demo golden readme sponza)
    add_test(NAME e2e_${name} COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/e2e/${name}.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
    set_tests_properties(e2e_${name} PROPERTIES LABELS "e2e" SKIP_RETURN_CODE 77)
  endforeach()
  # The page is tested in a real browser, which is slow enough without a sanitizer.
  add_test(NAME browser_page COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/browser/page.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
  # It runs alone: a browser that draws without a GPU shows hardly a frame beside other work.
  set_tests_properties(browser_page PROPERTIES LABELS "e2e" SKIP_RETURN_CODE 77 RUN_SERIAL ON)
  # A build with sanitizers is not hardened in the way that two of these tests check, and a program that is killed
  # reports nothing to a sanitizer.
  foreach(name hardened kills service)
    add_test(NAME e2e_${name} COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/e2e/${name}.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
    set_tests_properties(e2e_${name} PROPERTIES LABELS "e2e" SKIP_RETURN_CODE 77)
  endforeach()
endif()
