/// \file
/// Packing of the volume, the top-hat and the brick marks: word-parallel passes over rows of bits.
/// Contracts: engine/backend/backend.h.

/// Eight bytes as eight bits: bit i is set where byte i is not zero.
static ulong thin_nonzero(uchar8 bytes) {
  const ulong low = 0x7f7f7f7f7f7f7f7fUL, high = 0x8080808080808080UL;
  const ulong all = as_ulong(bytes);
  const ulong flags = (((all & low) + low) | all) & high;
  return ((flags >> 7) * 0x0102040810204080UL) >> 56;
}

/// Voxels x..x + 7 of a row of the caller's, as bits; those outside it are background.
static ulong thin_eight(global const uchar *row, int bytes, long x, long size) {
  if (x < 0 || x >= size) return 0;
  if (!bytes) return row[x / 8] & (0xff >> (8 - min(size - x, 8L)));
  if (x + 8 <= size) return thin_nonzero(vload8(0, row + x));
  ulong bits = 0;
  for (long i = x; i < size; ++i) bits |= (ulong)(row[i] != 0) << (i - x);
  return bits;
}

/// A work-item a word.
kernel __attribute__((ELEMENT_GROUP)) void volume_pack(
    VIEW(const uchar, volume), long4 given, int bytes, int4 size, ulong word_count,
    VIEW(ulong, words)) {
  TAKE(volume);
  TAKE(words);
  const ulong i = get_global_id(0);
  if (i >= word_count) return;
  const ulong row = i / size.w;
  const long x = 64 * (long)(i % size.w) - THIN_PAD, y = (long)(row % size.y) - THIN_PAD,
             z = (long)(row / size.y) - THIN_PAD;
  ulong word = 0;
  if (y >= 0 && y < given.y && z >= 0 && z < given.z) {
    global const uchar *from = volume + (z * given.y + y) * (bytes ? given.x : (given.x + 7) / 8);
    for (int k = 0; k < 8; ++k) word |= thin_eight(from, bytes, x + 8 * k, given.x) << (8 * k);
  }
  words[i] = word;
}

// --- The top-hat. A work-item a row; size.w is the words of a row. ---------------------------

/// The 3 x 3 rows round a row, word w of each: all of them, or any of them.
static ulong thin_all_nine(global const ulong *row, int4 size, int w) {
  const long slice = (long)size.w * size.y;
  ulong all = row[w];
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy) all &= row[dz * slice + dy * size.w + w];
  return all;
}

static ulong thin_any_nine(global const ulong *row, int4 size, int w) {
  const long slice = (long)size.w * size.y;
  ulong any = row[w];
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy) any |= row[dz * slice + dy * size.w + w];
  return any;
}

static bool thin_is_empty(global const ulong *row, int words) {
  ulong any = 0;
  for (int w = 0; w < words; ++w) any |= row[w];
  return any == 0;
}

static void thin_clear(global ulong *row, int words) {
  for (int w = 0; w < words; ++w) row[w] = 0;
}

/// Rows at the volume's rim have no rows round them, and no object.
static bool thin_at_rim(ulong row, int4 size) {
  const int y = row % size.y, z = row / size.y;
  return y == 0 || y == size.y - 1 || z == 0 || z == size.z - 1;
}

/// eroded = the object eroded by the cube.
kernel __attribute__((ELEMENT_GROUP)) void points_thin_erode(
    int4 size, ulong rows, VIEW(const ulong, object), VIEW(ulong, eroded)) {
  const ulong row = get_global_id(0);
  if (row >= rows) return;
  object += object_first + row * size.w;
  eroded += eroded_first + row * size.w;
  if (thin_at_rim(row, size) || thin_is_empty(object, size.w)) {
    thin_clear(eroded, size.w);
    return;
  }
  ulong below = 0, own = thin_all_nine(object, size, 0);
  for (int w = 0; w < size.w; ++w) {
    const ulong above = w + 1 < size.w ? thin_all_nine(object, size, w + 1) : 0;
    eroded[w] = own & (own >> 1 | above << 63) & (own << 1 | below >> 63);
    below = own;
    own = above;
  }
}

/// thin = the object without the eroded object dilated by the cube; flags: a byte a row, whether it
/// has any.
kernel __attribute__((ELEMENT_GROUP)) void points_thin_subtract(
    int4 size, ulong rows, VIEW(const ulong, object), VIEW(const ulong, eroded), VIEW(ulong, thin),
    VIEW(uchar, flags)) {
  const ulong row = get_global_id(0);
  if (row >= rows) return;
  object += object_first + row * size.w;
  eroded += eroded_first + row * size.w;
  thin += thin_first + row * size.w;
  TAKE(flags);
  flags[row] = 0;
  if (thin_at_rim(row, size) || thin_is_empty(object, size.w)) {
    thin_clear(thin, size.w);
    return;
  }
  ulong below = 0, own = thin_any_nine(eroded, size, 0), found = 0;
  for (int w = 0; w < size.w; ++w) {
    const ulong above = w + 1 < size.w ? thin_any_nine(eroded, size, w + 1) : 0;
    const ulong opened = own | own >> 1 | above << 63 | own << 1 | below >> 63;
    thin[w] = object[w] & ~opened;
    found |= object[w] & ~opened;
    below = own;
    own = above;
  }
  flags[row] = found != 0;
}

/// refine = thin dilated by the cube.
kernel __attribute__((ELEMENT_GROUP)) void points_thin_dilate(
    int4 size, ulong rows, VIEW(const ulong, thin), VIEW(const uchar, flags), VIEW(ulong, refine)) {
  const ulong row = get_global_id(0);
  if (row >= rows) return;
  thin += thin_first + row * size.w;
  flags += flags_first + row;
  refine += refine_first + row * size.w;
  bool near = false;
  if (!thin_at_rim(row, size))
    for (int dz = -size.y; dz <= size.y; dz += size.y)
      near = near || flags[dz - 1] || flags[dz] || flags[dz + 1];
  if (!near) {
    thin_clear(refine, size.w);
    return;
  }
  ulong below = 0, own = thin_any_nine(thin, size, 0);
  for (int w = 0; w < size.w; ++w) {
    const ulong above = w + 1 < size.w ? thin_any_nine(thin, size, w + 1) : 0;
    refine[w] = own | own >> 1 | above << 63 | own << 1 | below >> 63;
    below = own;
    own = above;
  }
}

// --- Brick marks. ----------------------------------------------------------------------------

/// Outer boundary voxels of word w of row (y, z).
static ulong thin_boundary(global const ulong *object, int4 size, int w, int y, int z) {
  const long slice = (long)size.w * size.y;
  global const ulong *own = object + z * slice + y * size.w + w;
  ulong near = own[0] >> 1 | own[0] << 1;
  if (w + 1 < size.w) near |= own[1] << 63;
  if (w > 0) near |= own[-1] >> 63;
  if (y > 0) near |= own[-size.w];
  if (y + 1 < size.y) near |= own[size.w];
  if (z > 0) near |= own[-slice];
  if (z + 1 < size.z) near |= own[slice];
  return near & ~own[0];
}

/// Whether word w and the bits beside it are empty in all rows of a brick row and those beside it.
static bool thin_column_is_empty(global const ulong *object, int4 size, int w, int by, int bz) {
  const long slice = (long)size.w * size.y;
  ulong any = 0;
  for (int z = max(8 * bz - 1, 0); z < min(8 * bz + 9, size.z); ++z)
    for (int y = max(8 * by - 1, 0); y < min(8 * by + 9, size.y); ++y) {
      global const ulong *own = object + z * slice + y * size.w + w;
      any |= own[0];
      if (w + 1 < size.w) any |= own[1] & 1;
      if (w > 0) any |= own[-1] >> 63;
    }
  return any == 0;
}

/// A work-item the eight bricks that share words.
kernel __attribute__((PLAIN_ELEMENT_GROUP)) void points_mark_bricks(
    int4 size, ulong count, VIEW(const ulong, object), VIEW(uchar, octants)) {
  const ulong i = get_global_id(0);
  if (i >= count) return;
  TAKE(object);
  const int w = i % size.w, brick_row = i / size.w;
  const int bricks = size.x / 8, by = brick_row % (size.y / 8), bz = brick_row / (size.y / 8);
  octants += octants_first + (size_t)brick_row * bricks + 8 * w;
  const int last = min(8, bricks - 8 * w);
  for (int b = 0; b < last; ++b) octants[b] = 0;
  if (thin_column_is_empty(object, size, w, by, bz)) return;
  for (int octant_row = 0; octant_row < 4; ++octant_row) {
    const int y = 8 * by + 4 * (octant_row & 1), z = 8 * bz + 4 * (octant_row >> 1);
    ulong boundary = 0;
    for (int row = 0; row < 16; ++row)
      boundary |= thin_boundary(object, size, w, y + row % 4, z + row / 4);
    for (int b = 0; b < last; ++b) {
      const ulong eight = boundary >> (8 * b);
      const uint pair = ((eight & 0x0f) != 0) | ((eight & 0xf0) != 0) << 1;
      octants[b] |= pair << (2 * octant_row);
    }
  }
}
