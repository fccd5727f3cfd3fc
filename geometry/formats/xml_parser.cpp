#include "geometry/formats/xml_parser.h"

#include <expat.h>

namespace kerf::internal {
namespace {

constexpr std::size_t kMostDepth = 64, kLongestToken = std::size_t{1} << 20;
constexpr const char* kDamagedXml = "the file is damaged; export it again";

auto xmlLine(XML_Parser parser) {
#if XML_MAJOR_VERSION > 2 || XML_MINOR_VERSION >= 9
  return XML_GetCurrentLineNumber64(parser);
#else
  return XML_GetCurrentLineNumber(parser);
#endif
}

}  // namespace

// Called through C: exceptions must not cross it.
struct XmlParser::Callbacks {
  template <class Work>
  static void run(XmlParser& xml, Work&& work) {
    xml.since_event_ = 0;
    if (xml.error_ || xml.out_of_memory_) return;  // expat may finish an empty element after a stop
    try {
      if (Expected<void> done = work(); !done) xml.error_ = std::move(done).error();
    } catch (const std::bad_alloc&) {
      xml.out_of_memory_ = true;
    }
    if (xml.error_ || xml.out_of_memory_) XML_StopParser(xml.parser_, XML_FALSE);
  }

  static void start(void* user, const char* name, const char** attributes) {
    auto& xml = *static_cast<XmlParser*>(user);
    run(xml, [&]() -> Expected<void> {
      if (++xml.depth_ > kMostDepth)
        return fail(xml.here(Error::Code::kUnsupported, "elements nested deeper than " + std::to_string(kMostDepth),
                             "flat XML", kDamagedXml));
      return xml.handler_.start(name, XmlAttributes(attributes));
    });
  }
  static void end(void* user, const char*) {
    auto& xml = *static_cast<XmlParser*>(user);
    run(xml, [&] {
      --xml.depth_;
      return xml.handler_.end();
    });
  }
  static void prefix(void* user, const char* prefix, const char* name_space) {
    auto& xml = *static_cast<XmlParser*>(user);
    run(xml, [&]() -> Expected<void> {
      xml.handler_.prefix(prefix ? prefix : "", name_space ? name_space : "");
      return {};
    });
  }
  static void doctype(void* user, const char*, const char*, const char*, int) {
    auto& xml = *static_cast<XmlParser*>(user);
    run(xml, [&]() -> Expected<void> {
      return fail(xml.here(Error::Code::kUnsupported, "a document type declaration", "XML without one",
                           "export the file again, or delete the line <!DOCTYPE ...>"));
    });
  }
  static void other(void* user, const char*, int) { static_cast<XmlParser*>(user)->since_event_ = 0; }
};

XmlParser::XmlParser(const MeshSource& source, std::string_view part, Handler& handler)
    : source_(source), part_(part), handler_(handler), parser_(XML_ParserCreateNS(nullptr, ' ')) {
  if (!parser_) throw std::bad_alloc();
  XML_SetUserData(parser_, this);
  XML_SetElementHandler(parser_, Callbacks::start, Callbacks::end);
  XML_SetStartNamespaceDeclHandler(parser_, Callbacks::prefix);
  XML_SetStartDoctypeDeclHandler(parser_, Callbacks::doctype);
  XML_SetDefaultHandler(parser_, Callbacks::other);
}

XmlParser::~XmlParser() { XML_ParserFree(parser_); }

Error XmlParser::here(Error::Code code, std::string found, std::string expected, std::string hint) const {
  return {code,
          source_.file,
          inQuotes(part_) + " line " + std::to_string(xmlLine(parser_)),
          std::move(found),
          std::move(expected),
          std::move(hint)};
}

Expected<void> XmlParser::feed(std::string_view piece, bool is_last) {
  since_event_ += piece.size();
  const XML_Status status = XML_Parse(parser_, piece.data(), static_cast<int>(piece.size()), is_last ? 1 : 0);
  if (out_of_memory_) throw std::bad_alloc();
  if (error_) return fail(*error_);
  if (status != XML_STATUS_OK) {
    const XML_Error code = XML_GetErrorCode(parser_);
    if (code == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
    return fail(
        here(Error::Code::kBadFormat, std::string("no well-formed XML: ") + XML_ErrorString(code), "XML", kDamagedXml));
  }
  if (since_event_ > kLongestToken)
    return fail(here(Error::Code::kUnsupported, "a tag or comment longer than 1 MiB", "shorter ones", kDamagedXml));
  return {};
}

}  // namespace kerf::internal
