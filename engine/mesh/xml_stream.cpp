#include "engine/mesh/xml_stream.h"

#include "engine/mesh/text_scan.h"

#include <exception>
#include <utility>

#include <expat.h>

namespace voidpath::mesh {

namespace {

/// Elements deeper than this are no 3MF; also bounds what the parser keeps in memory.
constexpr std::size_t kMaxDepth = 64;

/// Stands between namespace and name in what the parser reports; no address contains it.
constexpr char kSpaceEnd = '|';

std::pair<std::string_view, std::string_view> name_and_space(std::string_view full) {
  const std::size_t end = full.rfind(kSpaceEnd);
  if (end == full.npos) return {full, {}};
  return {full.substr(end + 1), full.substr(0, end)};
}

}  // namespace

const char* XmlAttributes::find(std::string_view name) const {
  for (const char** p = pairs_; *p; p += 2) {
    if (name == *p) return p[1];
  }
  return nullptr;
}

const char* XmlAttributes::find_in(std::string_view space, std::string_view name) const {
  for (const char** p = pairs_; *p; p += 2) {
    const auto [local, its_space] = name_and_space(*p);
    if (local == name && its_space.find(space) != its_space.npos) return p[1];
  }
  return nullptr;
}

struct XmlStream::Impl {
  FileBytes file;
  std::string part;
  Handler handler;
  XML_Parser parser = nullptr;
  std::exception_ptr thrown;
  std::size_t depth = 0;

  /// C code must not see exceptions: they are kept, parsing stops, feed() throws them on.
  template <class Call>
  void guarded(Call&& call) {
    if (thrown) return;
    try {
      call();
    } catch (...) {
      thrown = std::current_exception();
      XML_StopParser(parser, XML_FALSE);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    refuse(file, "part " + part + ", line " + std::to_string(XML_GetCurrentLineNumber(parser)) + ": " + what);
  }

  static void XMLCALL on_begin(void* self, const XML_Char* name, const XML_Char** attributes) {
    auto& me = *static_cast<Impl*>(self);
    me.guarded([&] {
      if (++me.depth > kMaxDepth) me.fail("elements nested deeper than " + std::to_string(kMaxDepth));
      const auto [local, space] = name_and_space(name);
      if (me.handler.begin) me.handler.begin(local, space, XmlAttributes(attributes));
    });
  }

  static void XMLCALL on_end(void* self, const XML_Char* name) {
    auto& me = *static_cast<Impl*>(self);
    me.guarded([&] {
      --me.depth;
      const auto [local, space] = name_and_space(name);
      if (me.handler.end) me.handler.end(local, space);
    });
  }

  static void XMLCALL on_doctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    auto& me = *static_cast<Impl*>(self);
    me.guarded([&] { me.fail("a document type declaration (DTD), which 3MF forbids"); });
  }

  static void XMLCALL on_declaration(void* self, const XML_Char*, const XML_Char* encoding, int) {
    auto& me = *static_cast<Impl*>(self);
    me.guarded([&] {
      if (encoding && !same_word(encoding, "utf-8") && !same_word(encoding, "utf-16")) {
        me.fail("encoding " + in_quotes(encoding) + "; 3MF must be UTF-8 or UTF-16");
      }
    });
  }

  void parse(std::string_view piece, bool last) {
    const XML_Status status = XML_Parse(parser, piece.data(), static_cast<int>(piece.size()), last ? 1 : 0);
    if (thrown) std::rethrow_exception(thrown);
    if (status == XML_STATUS_OK) return;
    fail(std::string("not well-formed XML in UTF-8 or UTF-16 (") + XML_ErrorString(XML_GetErrorCode(parser)) +
         ")");
  }
};

XmlStream::XmlStream(const FileBytes& file, std::string part, Handler handler)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->part = std::move(part);
  impl_->handler = std::move(handler);
  impl_->parser = XML_ParserCreateNS(nullptr, kSpaceEnd);
  if (!impl_->parser) throw std::bad_alloc();
  XML_SetUserData(impl_->parser, impl_.get());
  XML_SetElementHandler(impl_->parser, Impl::on_begin, Impl::on_end);
  XML_SetStartDoctypeDeclHandler(impl_->parser, Impl::on_doctype);
  XML_SetXmlDeclHandler(impl_->parser, Impl::on_declaration);
}

XmlStream::~XmlStream() { XML_ParserFree(impl_->parser); }

void XmlStream::feed(std::string_view piece) { impl_->parse(piece, false); }
void XmlStream::finish() { impl_->parse({}, true); }

void XmlStream::fail(const std::string& what) const { impl_->fail(what); }

}  // namespace voidpath::mesh
