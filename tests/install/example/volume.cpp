// Prints the size of a label volume. The reader is loaded from the installed Kerf.
#include <kerf/kerf.h>

#include <cstdio>

int main(int count, char** words) {
  if (count != 2) return 2;
  const auto volume = kerf::readLabelVolume(words[1]);
  if (!volume) {
    std::fprintf(stderr, "%s\n", volume.error().message().c_str());
    return 1;
  }
  std::printf("%d x %d x %d\n", volume->size[0], volume->size[1], volume->size[2]);
  return 0;
}
