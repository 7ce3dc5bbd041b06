/// \file  A file system that fails on request: the layer below SQLite (sqlite3_vfs).
#pragma once

#include <sqlite3.h>

#include <map>
#include <stdexcept>

namespace cornerfix::testing {

/// While it lives, new connections use it. Writes, syncs and truncations are steps. When it is
/// armed, so many steps pass and all after them fail, until disarm(): as on a disk that is full or
/// broken. One at a time; not for several threads.
class FailingVfs {
 public:
  FailingVfs() {
    real() = sqlite3_vfs_find(nullptr);
    vfs_ = *real();
    vfs_.zName = "cornerfix_failing";
    vfs_.xOpen = &open;
    if (sqlite3_vfs_register(&vfs_, 1) != SQLITE_OK) throw std::runtime_error("no vfs");
  }
  ~FailingVfs() {
    disarm();
    sqlite3_vfs_unregister(&vfs_);
    sqlite3_vfs_register(real(), 1);
  }
  FailingVfs(const FailingVfs&) = delete;
  FailingVfs& operator=(const FailingVfs&) = delete;

  /// `code`: SQLITE_FULL, SQLITE_IOERR_WRITE and the like.
  void arm(int steps, int code) { plan() = {true, false, steps, code}; }
  /// Returns whether a step has failed.
  bool disarm() {
    plan().is_armed = false;
    return plan().has_failed;
  }

 private:
  struct Plan {
    bool is_armed = false;
    bool has_failed = false;
    int steps_left = 0;
    int code = SQLITE_OK;
  };

  // SQLite calls plain functions, so what they need is global.
  static sqlite3_vfs*& real() {
    static sqlite3_vfs* vfs = nullptr;
    return vfs;
  }
  static Plan& plan() {
    static Plan current;
    return current;
  }
  static sqlite3_io_methods& original() {
    static sqlite3_io_methods methods;
    return methods;
  }

  static int step() {
    Plan& now = plan();
    if (!now.is_armed || --now.steps_left >= 0) return SQLITE_OK;
    now.has_failed = true;
    return now.code;
  }

  static int write(sqlite3_file* file, const void* from, int size, sqlite3_int64 offset) {
    const int code = step();
    return code == SQLITE_OK ? original().xWrite(file, from, size, offset) : code;
  }
  static int truncate(sqlite3_file* file, sqlite3_int64 size) {
    const int code = step();
    return code == SQLITE_OK ? original().xTruncate(file, size) : code;
  }
  static int sync(sqlite3_file* file, int flags) {
    const int code = step();
    return code == SQLITE_OK ? original().xSync(file, flags) : code;
  }

  static int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
    // Files of other kinds have other tables, with the same functions for what is patched here.
    static std::map<const sqlite3_io_methods*, sqlite3_io_methods> tables;
    const int code = real()->xOpen(real(), name, file, flags, out);
    if (code != SQLITE_OK || file->pMethods == nullptr) return code;
    original() = *file->pMethods;
    sqlite3_io_methods& patched = tables[file->pMethods] = original();
    patched.xWrite = &write;
    patched.xTruncate = &truncate;
    patched.xSync = &sync;
    file->pMethods = &patched;
    return code;
  }

  sqlite3_vfs vfs_{};
};

}  // namespace cornerfix::testing
