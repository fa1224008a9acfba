// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the library throws. Every message names the element, the value and the rule it breaks.
///
/// Exceptions leave construction, reading and editing. A simulation step never throws for physics:
/// it returns a StepReport.
///
/// What was moved from can be destroyed and assigned to. To all other calls it is empty, or throws
/// InvalidArgument.

#include <stdexcept>
#include <string>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Base of all exceptions of this library.
class PBDSURG_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A parameter outside its documented range.
class PBDSURG_API InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// A mesh that breaks one of its invariants, or a surface that cannot be filled with tetrahedra.
class PBDSURG_API InvalidMesh : public Error {
 public:
  using Error::Error;
};

/// A file that cannot be opened, read to its end, understood or written.
class PBDSURG_API FileError : public Error {
 public:
  using Error::Error;

  /// "path:line: reason", for text.
  static FileError at_line(const std::string& path, long line, const std::string& reason);

  /// "path: byte offset: reason", for binary data.
  static FileError at_byte(const std::string& path, long long offset, const std::string& reason);
};

/// A backend or device that was asked for and is not there; the message says why.
class PBDSURG_API BackendUnavailable : public Error {
 public:
  using Error::Error;
};

}  // namespace pbdsurg
