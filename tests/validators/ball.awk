# Writes a ball of radius 5 mm, 528 triangles, as ASCII STL, sound or spoilt:
#   -v skip=N    without triangle N                    -v second=X  a second ball, centred at (X, 0, 0)
#   -v flip=N    triangle N turned around (-1: all)    -v poke=1    one vertex pulled through its neighbours
function point(i, j,    polar, turn) {
  if (i == 0) return sprintf("%.6f 0.000000 5.000000", centre)
  if (i == rings) return sprintf("%.6f 0.000000 -5.000000", centre)
  if (poke && i == rings / 2 && j % sectors == 0) return "3.900000 3.900000 0.200000"
  polar = pi * i / rings
  turn = 2 * pi * (j % sectors) / sectors
  return sprintf("%.6f %.6f %.6f", centre + 5 * sin(polar) * cos(turn), 5 * sin(polar) * sin(turn), 5 * cos(polar))
}
function triangle(a, b, c,    swap) {
  number++
  if (number == skip) return
  if (number == flip || flip == -1) { swap = b; b = c; c = swap }
  printf "facet normal 0 0 0\nouter loop\nvertex %s\nvertex %s\nvertex %s\nendloop\nendfacet\n", a, b, c
}
function ball(x,    i, j) {
  centre = x
  for (i = 0; i < rings; i++)
    for (j = 0; j < sectors; j++) {
      if (i > 0) triangle(point(i, j), point(i + 1, j), point(i, j + 1))
      if (i < rings - 1) triangle(point(i, j + 1), point(i + 1, j), point(i + 1, j + 1))
    }
}
BEGIN {
  pi = atan2(0, -1); rings = 12; sectors = 24
  print "solid ball"
  ball(0)
  if (second) ball(second)
  print "endsolid ball"
}
