pbdsurg_room(core
  HEADERS types.h bits.h error.h export.h host_device.h ids.h mailbox.h owned.h random.h select.h
          thread_wait.h undo_array.h vec3.h write_file.h
  SOURCES error.cpp processors.cpp write_file.cpp)
