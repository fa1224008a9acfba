pbdsurg_room(coloring
  HEADERS constraint_vertices.h coloring.h color.h
          greedy.h luby.h jones_plassmann.h random_disc.h repair.h balance.h conflict_graph.h
          edge_ownership.h clusters.h
  SOURCES constraint_vertices.cpp coloring.cpp color_gaps.cpp color_tables.cpp
          first_fit.cpp greedy.cpp jones_plassmann.cpp luby.cpp random_disc.cpp
          repair.cpp balance.cpp chain_balance.cpp color.cpp conflict_graph.cpp
          edge_ownership.cpp clusters.cpp)
