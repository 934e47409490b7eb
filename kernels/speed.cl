/// \file
/// What a device can do at best, for host/opencl/speed.cpp.

/// a = b + 3 c, sixteen elements an item (McCalpin's triad, 1995).
kernel void speed_triad(global float16 *a, global const float16 *b, global const float16 *c) {
  const size_t i = get_global_id(0);
  a[i] = b[i] + 3.0f * c[i];
}

/// Additions and multiplications of 64 lanes an item, without fma.
kernel void speed_arithmetic(global float16 *results, uint rounds) {
  float16 x = 0.5f, y = 0.25f, z = 0.125f, w = 0.0625f;
  for (uint round = 0; round < rounds; ++round) {
    x = x * 0.9f + 0.1f;
    y = y * 0.9f + 0.1f;
    z = z * 0.9f + 0.1f;
    w = w * 0.9f + 0.1f;
  }
  results[get_global_id(0)] = (x + y) + (z + w);
}
