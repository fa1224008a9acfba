pbdsurg_room(constraints
  HEADERS projection.h distance.h volume.h attachment.h contact.h vertex_block.h)
