// The guard that a process has started, found by its name.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace kerf::test {

/// 0: none. Of several any one.
inline pid_t guardOf(pid_t parent) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "stat");
    std::string text;
    std::getline(file, text);
    const std::size_t name = text.find("(kerf-zero-guard)");
    if (name == text.npos) continue;
    char state = 0;
    pid_t its_parent = 0;
    if (std::sscanf(text.c_str() + name, "(kerf-zero-guard) %c %d", &state, &its_parent) == 2 && its_parent == parent &&
        state != 'Z')
      return std::stoi(entry.path().filename().string());
  }
  return 0;
}

}  // namespace kerf::test
