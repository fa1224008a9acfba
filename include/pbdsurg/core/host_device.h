// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// PBDSURG_HOST_DEVICE marks functions whose one source serves the CPU and CUDA.

#if defined(__CUDACC__)
#define PBDSURG_HOST_DEVICE __host__ __device__
#else
#define PBDSURG_HOST_DEVICE
#endif
