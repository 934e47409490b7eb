/// \file
/// Sums and scans over flat arrays (fills are the runtime's own). Contracts and order of
/// arithmetic: engine/backend/backend.h.

/// values[3 i] = a * b + c of the i-th three factors, then a / b and the square root of a, for
/// host/opencl/arithmetic.cpp.
kernel void primitives_probe(global const float *factors, global float *values) {
  const size_t i = get_global_id(0);
  const float a = factors[3 * i], b = factors[3 * i + 1], c = factors[3 * i + 2];
  values[3 * i] = a * b + c;
  values[3 * i + 1] = a / b;
  values[3 * i + 2] = sqrt(a);
}

/// First fold of the pairwise sum: sums[i] = values[i] + values[i + half] for i < half, values past
/// `count` being zero. A work-item a sum.
kernel __attribute__((ELEMENT_GROUP)) void primitives_reduce_first(
    global const float *values, ulong values_first, ulong count, ulong half_count,
    global float *sums, ulong sums_first) {
  const size_t i = get_global_id(0);
  if (i >= half_count) return;
  values += values_first;
  const size_t upper = i + half_count;
  sums[sums_first + i] = values[i] + (upper < count ? values[upper] : 0.0f);
}

/// A later fold, in place: sums[i] += sums[i + half] for i < half.
kernel __attribute__((ELEMENT_GROUP)) void primitives_reduce_fold(
    global float *sums, ulong sums_first, ulong half_count) {
  const size_t i = get_global_id(0);
  if (i >= half_count) return;
  sums += sums_first;
  sums[i] += sums[i + half_count];
}

/// The last folds, in place, by one work-group: from 2 * half values down to sums[0].
kernel __attribute__((reqd_work_group_size(REDUCE_ITEMS, 1, 1))) void primitives_reduce_last(
    global float *sums, ulong sums_first, uint half_count) {
  sums += sums_first;
  for (uint n = half_count; n > 0; n /= 2) {
    for (uint i = get_local_id(0); i < n; i += REDUCE_ITEMS) sums[i] += sums[i + n];
    barrier(CLK_GLOBAL_MEM_FENCE);
  }
}

/// totals[block] = sum of the block's values; a block is SCAN_ITEMS * SCAN_RUN of them.
kernel __attribute__((reqd_work_group_size(SCAN_ITEMS, 1, 1))) void primitives_scan_totals(
    global const uint *values, ulong values_first, ulong count, global ulong *totals,
    ulong totals_first) {
  local ulong item_sum[SCAN_ITEMS];
  const size_t item = get_local_id(0), block = get_group_id(0);
  const size_t first = (block * SCAN_ITEMS + item) * SCAN_RUN;
  const size_t end = min((ulong)(first + SCAN_RUN), count);
  values += values_first;
  ulong sum = 0;
  for (size_t i = first; i < end; ++i) sum += values[i];
  item_sum[item] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item != 0) return;
  for (size_t i = 1; i < SCAN_ITEMS; ++i) sum += item_sum[i];
  totals[totals_first + block] = sum;
}

/// sums[i] = starts[block] + the values before i in its block. `sums` may be `values`.
kernel __attribute__((reqd_work_group_size(SCAN_ITEMS, 1, 1))) void primitives_scan_blocks(
    global const uint *values, ulong values_first, ulong count, global const ulong *starts,
    ulong starts_first, global uint *sums, ulong sums_first) {
  local uint item_sum[SCAN_ITEMS];
  const size_t item = get_local_id(0), block = get_group_id(0);
  const size_t first = (block * SCAN_ITEMS + item) * SCAN_RUN;
  const size_t end = min((ulong)(first + SCAN_RUN), count);
  values += values_first;
  sums += sums_first;
  uint sum = 0;
  for (size_t i = first; i < end; ++i) sum += values[i];
  item_sum[item] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  sum = (uint)starts[starts_first + block];
  for (size_t i = 0; i < item; ++i) sum += item_sum[i];
  for (size_t i = first; i < end; ++i) {
    const uint value = values[i];
    sums[i] = sum;
    sum += value;
  }
}
