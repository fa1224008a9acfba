pbdsurg_room(coloring
  HEADERS constraint_vertices.h coloring.h greedy.h luby.h jones_plassmann.h random_disc.h dynamic_coloring.h
  SOURCES constraint_vertices.cpp coloring.cpp color_gaps.cpp thread_team.cpp
          first_fit.cpp greedy.cpp jones_plassmann.cpp luby.cpp random_disc.cpp
          dynamic_coloring.cpp)
