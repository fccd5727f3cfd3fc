#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "tests/fuzz/file_harness.h"
#include "ui/app/base/language.h"

// The bytes are a language file. Looks up the lines of the same bytes in the result.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const fuzz::ScratchFile file("language.po");
  file.fill(data, size);
  auto language = Language::read(file.path());
  if (!language) {
    fuzz::requireError(language.error());
    return 0;
  }

  const std::string text(reinterpret_cast<const char*>(data), size);
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find('\n', from), text.size());
    (void)language->shown(text.substr(from, to - from));
    from = to + 1;
  }
  setShownLanguage(std::make_shared<const Language>(std::move(*language)));
  const std::string format = shownText("push %.1f N");
  fuzz::require(format.find("%.1f") != format.npos, "a format keeps its conversion");
  fuzz::require(format.find('%') == format.rfind('%'), "and has no other one");
  fuzz::require(phrase("about {} s", 4711).find("4711") != std::string::npos, "a phrase has its values");
  fuzz::require(shownLabel("Cancel").ends_with("###Cancel"), "an id is that of the English label");
  setShownLanguage(nullptr);
  return 0;
}
