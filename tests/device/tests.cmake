# Fake eye trackers: the project's programs run unmodified among umockdev's fake devices. Without umockdev these tests
# are skipped and say so.
pkg_check_modules(UMOCKDEV QUIET IMPORTED_TARGET umockdev-1.0)
add_executable(device_probe device/probe.c)
target_link_libraries(device_probe PRIVATE tracker m)
add_executable(device_reopen device/reopen.c)
target_link_libraries(device_reopen PRIVATE tracker)
if(UMOCKDEV_FOUND)
  add_library(fake STATIC device/fake.c device/fake_hid.c device/fake_usb.c)
  target_link_libraries(fake PUBLIC PkgConfig::UMOCKDEV util m)
  add_executable(device_plug device/plug.c)
  target_link_libraries(device_plug PRIVATE fake)
  add_executable(device_latency device/latency.c)
  target_link_libraries(device_latency PRIVATE fake tracker renderer m)
  add_dependencies(device_latency fovead-reader)
endif()
foreach(name hid psvr2 auto list conformance fovead views leak latency)
  add_test(NAME device_${name}
           COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/device/umockdev.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR} ${name})
  set_tests_properties(device_${name} PROPERTIES LABELS "device" SKIP_RETURN_CODE 77)
endforeach()

# A real kernel in a virtual machine, with trackers made through it.
add_executable(vm_hid device/vm_hid.c)
add_executable(vm_usb device/vm_usb.c)
target_link_libraries(vm_hid PRIVATE m)
add_test(NAME device_vm COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/device/vm.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
set_tests_properties(device_vm PROPERTIES LABELS "device" SKIP_RETURN_CODE 77)
