// SPDX-License-Identifier: Apache-2.0
// The one error type: a function that can fail returns Result<T>; nothing below `main` exits.
// Library exceptions end at the adapter that called the library.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace zc {

enum class ErrorCode {
  kArgument,     // the caller's words are wrong: exit code 2
  kIo,           // the operating system refused
  kMissing,      // a file that is not where it was looked for, where callers can go on without
  kFormat,       // bytes that do not follow their format
  kUnsupported,  // a valid input that zonecast does not handle
  kBudget,       // does not fit under the memory cap
  kDevice,       // the GPU or its driver refused
  kTransient,    // a network or a server failed for now: the same may work later
};

struct Error {
  ErrorCode code = ErrorCode::kFormat;
  std::string message;            // the cause, one line, no full stop
  std::string path = {};          // file the fault lies in, empty when none
  std::int64_t byte_offset = -1;  // place in that file, negative when unknown
  double retry_after_s = 0;       // when the cause asked not to be tried again sooner

  // "path:byte 12: cause", one line for a person.
  [[nodiscard]] std::string describe() const {
    std::string text = path;
    if (byte_offset >= 0) text += (text.empty() ? "byte " : ": byte ") + std::to_string(byte_offset);
    if (!text.empty()) text += ": ";
    return text + message;
  }
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] T& value() & { return std::get<0>(state_); }
  [[nodiscard]] const T& value() const& { return std::get<0>(state_); }
  [[nodiscard]] T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  [[nodiscard]] const Error& error() const& { return std::get<1>(state_); }
  [[nodiscard]] Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const& { return *error_; }
  [[nodiscard]] Error&& error() && { return *std::move(error_); }

 private:
  std::optional<Error> error_;
};

using Status = Result<void>;

}  // namespace zc

// Evaluate `expr` (a Result or Status); on failure return its error from the enclosing function.
#define ZC_CONCAT_INNER(a, b) a##b
#define ZC_CONCAT(a, b) ZC_CONCAT_INNER(a, b)
#define ZC_TRY(expr)                                                                   \
  do {                                                                                 \
    if (auto zc_status = (expr); !zc_status.ok()) return std::move(zc_status).error(); \
  } while (false)
#define ZC_ASSIGN_INNER(tmp, target, expr)      \
  auto tmp = (expr);                            \
  if (!tmp.ok()) return std::move(tmp).error(); \
  target = std::move(tmp).value()
// ZC_ASSIGN(auto x, f()): x = f()'s value, or return f()'s error.
#define ZC_ASSIGN(target, expr) ZC_ASSIGN_INNER(ZC_CONCAT(zc_result_, __LINE__), target, expr)
