pbdsurg_room(anatomy
  HEADERS organs.h membrane.h cholecystectomy_anatomy.h table2_family.h
  SOURCES organs.cpp membrane.cpp outer_surface.cpp cholecystectomy_anatomy.cpp tetgen_program.cpp
          table2_family.cpp)
