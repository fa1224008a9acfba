// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Marks for functions whose one source serves the CPU and CUDA.
///
/// PBDSURG_HOST_DEVICE: callable on both sides. PBDSURG_DEVICE: compiled for the device by nvcc and
/// for the host by other compilers, for code that calls what only one of the two has.

#if defined(__CUDACC__)
#define PBDSURG_HOST_DEVICE __host__ __device__
#define PBDSURG_DEVICE __device__
#else
#define PBDSURG_HOST_DEVICE
#define PBDSURG_DEVICE
#endif
