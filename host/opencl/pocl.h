#pragma once

/// \file
/// What PoCL, the OpenCL of processors, needs of the machine: a folder in which to keep what it
/// builds, and the linker ld. It ends the process where the folder is full or its files damaged, or
/// where there is no linker, and is no device without a folder; so both are seen to here.

#include <functional>
#include <string>

namespace vasamesh {

/// Has PoCL take a checked folder (kernel_folder.h) for this process's kernels: `vasamesh` in
/// $POCL_CACHE_DIR where that is set; else `pocl` in default_cache_folder(), or, where that cannot
/// be used, in vasamesh-<user's number> in the folder for temporary files.
/// \param list_devices  makes PoCL read POCL_CACHE_DIR, which is set to the folder meanwhile and
///        then put back. This counts for the whole process, and no other thread may ask for
///        environment variables at the time: to be called once, before the first device is.
void start_pocl(const std::function<void()>& list_devices);

/// Why there is no such folder, in words that follow PoCL's name, with the remedy; else empty.
const std::string& pocl_lacks_folder();

/// As above of the folder or the linker.
std::string pocl_lacks();

/// As KernelFolder::record(): for processes that do not live to their regular end.
void record_pocl_kernels() noexcept;

}  // namespace vasamesh
