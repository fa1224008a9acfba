pbdsurg_room(surgery
  HEADERS cautery.h connective_tissue.h
  SOURCES cautery.cpp connective_tissue.cpp current.cpp electrode_contact.cpp heat_changes.cpp)
