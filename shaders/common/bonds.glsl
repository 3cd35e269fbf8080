// Bonds in slices of 16 particles: a row holds 16 neighbours, then their 16 packed vectors.
#define SLICE 16

// Three signed 10-bit multiples of the reference grid, x lowest.
vec3 unpack_bond(uint word, float unit) {
  int code = int(word);
  return unit * vec3(float((code << 22) >> 22), float((code << 12) >> 22), float((code << 2) >> 22));
}
