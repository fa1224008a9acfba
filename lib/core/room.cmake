pbdsurg_room(core
  HEADERS types.h bits.h error.h executor.h export.h host_device.h ids.h mailbox.h owned.h random.h select.h
          undo_array.h vec3.h write_file.h
  SOURCES error.cpp executor.cpp processors.cpp step_team.cpp write_file.cpp)
