/// \file
/// The conjugate gradient's passes (eq. 2 of the paper on one level of bricks). Contracts and
/// order of arithmetic: engine/backend/backend.h. Rows are unrolled by the eight of a slice, so that
/// which of them reach into a neighbour is known to the compiler: twice as fast on a CPU.

/// Row of A p, unmasked.
static float8 poisson_row(global const float *field, global const int *near, float4 weights,
                          int row) {
  const int y = row & 7, z = row >> 3;
  const float8 p = brick_row(field, near, y, z);
  const float left = brick_cell_beside(field, near, -1, 7, row);
  const float right = brick_cell_beside(field, near, 1, 0, row);
  const float8 two = 2.0f * p;
  const float8 tx = (two - (float8)(left, p.s0123, p.s45, p.s6)) -
                    (float8)(p.s1234, p.s56, p.s7, right);
  const float8 ty = (two - brick_row(field, near, y - 1, z)) - brick_row(field, near, y + 1, z);
  const float8 tz = (two - brick_row(field, near, y, z - 1)) - brick_row(field, near, y, z + 1);
  return (weights.x * tx + weights.y * ty) + weights.z * tz;
}

/// `value` where a cell of the row is unknown, else 0.
static float8 poisson_where_unknown(global const uchar *unknown, size_t row, float8 value) {
  return select((float8)(0.0f), value, convert_int8(vload8(row, unknown)) != 0);
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void poisson_residual(
    VIEW(const int, neighbours), float4 weights, VIEW(const uchar, unknown), VIEW(const float, b),
    VIEW(const float, x), VIEW(float, r), VIEW(float, p), VIEW(float, b_square),
    VIEW(float, r_square)) {
  BRICK_SUM(b_sum);
  BRICK_SUM(r_sum);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  unknown += unknown_first + brick * BRICK_CELLS;
  b += b_first + brick * BRICK_CELLS;
  x += x_first;
  r += r_first + brick * BRICK_CELLS;
  p += p_first + brick * BRICK_CELLS;
  #pragma unroll 8
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const float8 wanted = poisson_where_unknown(unknown, row, vload8(row, b));
    const float8 image = poisson_where_unknown(unknown, row, poisson_row(x, near, weights, row));
    const float8 rest = wanted - image;
    vstore8(rest, row, r);
    vstore8(rest, row, p);
    brick_sum_add(b_sum, row, wanted * wanted);
    brick_sum_add(r_sum, row, rest * rest);
  }
  const float b_total = brick_sum_finish(b_sum), r_total = brick_sum_finish(r_sum);
  if (get_local_id(0) != 0) return;
  b_square[b_square_first + brick] = b_total;
  r_square[r_square_first + brick] = r_total;
}

kernel __attribute__((BRICK_GROUP)) void poisson_energy(
    VIEW(const int, neighbours), float4 weights, VIEW(const uchar, unknown), VIEW(const float, p),
    VIEW(float, energy)) {
  BRICK_SUM(sum);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  unknown += unknown_first + brick * BRICK_CELLS;
  p += p_first;
  #pragma unroll 8
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const float8 image = poisson_where_unknown(unknown, row, poisson_row(p, near, weights, row));
    brick_sum_add(sum, row, vload8(row, p + brick * BRICK_CELLS) * image);
  }
  const float total = brick_sum_finish(sum);
  if (get_local_id(0) == 0) energy[energy_first + brick] = total;
}

kernel __attribute__((BRICK_GROUP)) void poisson_update_solution(
    VIEW(const int, neighbours), float4 weights, VIEW(const uchar, unknown), float alpha,
    VIEW(const float, p), VIEW(float, x), VIEW(float, r), VIEW(float, r_square)) {
  BRICK_SUM(sum);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  unknown += unknown_first + brick * BRICK_CELLS;
  p += p_first;
  x += x_first + brick * BRICK_CELLS;
  r += r_first + brick * BRICK_CELLS;
  #pragma unroll 8
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const float8 image = poisson_where_unknown(unknown, row, poisson_row(p, near, weights, row));
    const float8 rest = vload8(row, r) - alpha * image;
    vstore8(vload8(row, x) + alpha * vload8(row, p + brick * BRICK_CELLS), row, x);
    vstore8(rest, row, r);
    brick_sum_add(sum, row, rest * rest);
  }
  const float total = brick_sum_finish(sum);
  if (get_local_id(0) == 0) r_square[r_square_first + brick] = total;
}

kernel __attribute__((BRICK_GROUP)) void poisson_update_direction(
    float beta, global const float *r, ulong r_first, global float *p, ulong p_first) {
  const size_t brick = get_group_id(0);
  r += r_first + brick * BRICK_CELLS;
  p += p_first + brick * BRICK_CELLS;
  #pragma unroll 8
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
    vstore8(vload8(row, r) + beta * vload8(row, p), row, p);
}
