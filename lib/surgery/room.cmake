pbdsurg_room(surgery
  HEADERS cautery.h connective_tissue.h cut.h
  SOURCES cautery.cpp connective_tissue.cpp current.cpp cut.cpp cut_neighborhood.cpp cut_planner.cpp
          cut_surface.cpp electrode_contact.cpp heat_changes.cpp)
