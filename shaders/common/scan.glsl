// Sums of all lanes before this one in a group of 256 (Hillis and Steele 1986), and of all lanes.
shared uint scan_value[2][256];

uint sum_before(uint value, out uint total) {
  uint lane = local_index(), now = 0u;
  scan_value[0][lane] = value;
  barrier();
  for (uint reach = 1u; reach < 256u; reach *= 2u) {
    uint sum = scan_value[now][lane];
    if (lane >= reach) sum += scan_value[now][lane - reach];
    now = 1u - now;
    scan_value[now][lane] = sum;
    barrier();
  }
  total = scan_value[now][255];
  uint result = scan_value[now][lane] - value;
  barrier();
  return result;
}
