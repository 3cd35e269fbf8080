// Cells of fluids: a lattice that repeats in each direction after as many cells as there are, x fastest.
int lattice_coordinate(float x, float per_cell) {
  float at = x * per_cell;
  return abs(at) < 1e9 ? int(floor(at)) : 0; // what is not finite shares one cell
}
uint wrapped(int at, uint cells) { // % is not defined for negative numbers
  int n = int(cells), turns = at >= 0 ? at / n : -((n - 1 - at) / n);
  return uint(at - turns * n);
}
uint lattice_cell(vec3 place, vec3 per_cell, uvec3 cells) {
  uint x = wrapped(lattice_coordinate(place.x, per_cell.x), cells.x);
  uint y = wrapped(lattice_coordinate(place.y, per_cell.y), cells.y);
  uint z = wrapped(lattice_coordinate(place.z, per_cell.z), cells.z);
  return (z * cells.y + y) * cells.x + x;
}
