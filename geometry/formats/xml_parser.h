// XML in pieces, by expat: elements and attributes with their namespaces, errors with part and line.
#pragma once

#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/formats/mesh_source.h"

struct XML_ParserStruct;

namespace kerf::internal {

/// The attributes of an element. Names without prefix are plain, others "NAMESPACE name".
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
  std::optional<std::string_view> find(std::string_view name) const {
    for (const char** p = pairs_; *p; p += 2)
      if (name == *p) return p[1];
    return std::nullopt;
  }

 private:
  const char** pairs_;
};

/// Rejects content that 3MF forbids or no mesh needs: a DTD with its entities, elements nested deeper than 64, and a
/// tag or comment longer than 1 MiB (expat would keep it in memory, and read it again with every piece).
class XmlParser {
 public:
  /// Receiver of the events. After an error no more events come.
  class Handler {
   public:
    virtual ~Handler() = default;
    virtual Expected<void> start(std::string_view name, const XmlAttributes& attributes) = 0;  ///< "NAMESPACE name"
    virtual Expected<void> end() = 0;
    virtual void prefix(std::string_view /*prefix*/, std::string_view /*name_space*/) {}
  };

  XmlParser(const MeshSource& source, std::string_view part, Handler& handler);
  ~XmlParser();
  XmlParser(const XmlParser&) = delete;
  XmlParser& operator=(const XmlParser&) = delete;

  /// @throws std::bad_alloc, when a handler did or expat has no memory left.
  Expected<void> feed(std::string_view piece, bool is_last = false);
  /// An error at the current place of the parser.
  Error here(Error::Code code, std::string found, std::string expected = {}, std::string hint = {}) const;

 private:
  struct Callbacks;
  const MeshSource& source_;
  std::string part_;
  Handler& handler_;
  XML_ParserStruct* parser_;
  std::optional<Error> error_;
  bool out_of_memory_ = false;
  std::size_t depth_ = 0, since_event_ = 0;
};

}  // namespace kerf::internal
