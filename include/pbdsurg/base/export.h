// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a shared library shows. Everything else is hidden, whatever the project that builds it
/// asks for (`CMAKE_CXX_VISIBILITY_PRESET`).

/// Before a function, after `class` or `struct`: part of the interface of the shared library.
/// Private headers mark what pbdsurg::cuda takes from pbdsurg::core.
#define PBDSURG_API __attribute__((visibility("default")))
