// SPDX-License-Identifier: Apache-2.0
#if !defined(PBDSURG_CATCH2_3)
#define CATCH_CONFIG_MAIN
#endif
#include "tests/support/catch.h"
