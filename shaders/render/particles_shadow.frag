// The side of a sphere that faces the sun.
in vec2 place;
flat in float middle, radius;

void main() {
  float inside = 1.0 - dot(place, place);
  if (inside <= 0.0) discard;
  gl_FragDepth = middle - radius * sqrt(inside);
}
