// kerf-slice-trial FORMAT MAX-BYTES: reads slices before Kerf does. Standard input is a socket: the paths come from it,
// each ended by a zero; a byte goes back when it has them, another once all slices are read.
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string>

#include "preprocess/volume/slice_trial.h"

int main(int count, char** words) {
  using namespace kerf::internal;
  if (count != 3) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{};
  setrlimit(RLIMIT_CORE, &no_core);

  std::string list;
  char part[4096];
  for (ssize_t n = 0; (n = read(STDIN_FILENO, part, sizeof part)) != 0;) {
    if (n > 0)
      list.append(part, static_cast<std::size_t>(n));
    else if (errno != EINTR)
      return 2;
  }
  std::vector<std::filesystem::path> files;
  for (std::size_t at = 0; at < list.size(); at += files.back().native().size() + 1) files.emplace_back(&list[at]);

  const auto& reader = *kerfItkReader();
  if (write(STDIN_FILENO, "r", 1) != 1) return 2;
  const auto format = static_cast<VolumeFormat>(std::atoi(words[1]));
  if (!readEverySlice(reader, files, format, std::strtoull(words[2], nullptr, 10))) return 1;
  return write(STDIN_FILENO, "+", 1) == 1 ? 0 : 2;
}
