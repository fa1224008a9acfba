pbdsurg_room(constraints
  HEADERS projection.h distance.h volume.h attachment.h bending.h contact.h neo_hookean.h
          strain_limit.h vertex_block.h
  SOURCES bending.cpp)
