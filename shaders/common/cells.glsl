// Hashed cells: a row of cells along x has numbers that follow each other from the hash of its y and z.
int cell_coordinate(float x, float per_cell) {
  float at = x * per_cell;
  return abs(at) < 1e9 ? int(floor(at)) : 0; // what is lost or not finite shares one cell
}
ivec3 cell_at(vec3 x, float per_cell) {
  return ivec3(cell_coordinate(x.x, per_cell), cell_coordinate(x.y, per_cell), cell_coordinate(x.z, per_cell));
}
uint row_hash(int y, int z) {
  uint h = uint(y) * 2654435761u ^ uint(z) * 2246822519u;
  h ^= h >> 15;
  h *= 739982445u;
  return h ^ (h >> 12);
}
uint cell_number(ivec3 cell, uint mask) { return (row_hash(cell.y, cell.z) + uint(cell.x)) & mask; }
