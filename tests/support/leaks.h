#pragma once

/// \file
/// Leaks of ITK's own when it refuses a file, for LeakSanitizer to pass over. Include it once in a
/// test program.

#if defined(__SANITIZE_ADDRESS__)
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libITKNrrdIO\nleak:libITKMetaIO\nleak:libITKIO\nleak:libITKniftiio\nleak:libgdcm\n";
}
#endif
