#include "libaccel/io/accel_file.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <utility>

#define XXH_STATIC_LINKING_ONLY  // the size of XXH3_state_t
#include <xxhash.h>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/atomic_file.h"
#include "libaccel/io/mapped_file.h"

namespace accel {
namespace {

// The first byte is no text, and CR LF and LF show transfers that changed line ends.
constexpr char kMagic[8] = {'\x89', 'A', 'C', 'C', '\r', '\n', '\x1a', '\n'};
constexpr std::uint32_t kByteOrder = 0x01020304u;
constexpr std::uint32_t kOtherByteOrder = 0x04030201u;
constexpr std::uint64_t kAlignment = kBufferAlignment;
constexpr std::uint32_t kMostSections = 4096;

struct FileHeader {
  char magic[8];
  std::uint32_t version;
  std::uint32_t byte_order;
  std::uint64_t file_size;
  std::uint32_t section_count;
  std::uint32_t reserved[5];
  std::uint64_t table_checksum;
  std::uint64_t header_checksum;  // of all bytes before it
};
static_assert(sizeof(FileHeader) == 64 && std::is_trivially_copyable_v<FileHeader>);

struct TableEntry {
  char name[24];  // ends in at least one zero
  std::uint64_t offset;
  std::uint64_t size_bytes;
  std::uint32_t element_size;
  std::uint32_t reserved[3];
  std::uint64_t checksum;  // of the section with its padding
};
static_assert(sizeof(TableEntry) == 64 && kAlignment % sizeof(TableEntry) == 0 && std::is_trivially_copyable_v<TableEntry>);

std::uint64_t padded(std::uint64_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

// Where the sections begin: behind the table, which zeros pad.
std::uint64_t table_end(std::size_t sections) { return padded(sizeof(FileHeader) + sections * sizeof(TableEntry)); }

std::uint64_t checksum(const void* data, std::size_t size) { return XXH3_64bits(data, size); }

std::uint64_t header_checksum(const FileHeader& header) { return checksum(&header, offsetof(FileHeader, header_checksum)); }

// The checksum of bytes and of the zeros that pad them.
std::uint64_t padded_checksum(std::span<const std::byte> bytes) {
  constexpr std::byte kZeros[kAlignment] = {};
  XXH3_state_t state;
  XXH3_64bits_reset(&state);
  XXH3_64bits_update(&state, bytes.data(), bytes.size());
  XXH3_64bits_update(&state, kZeros, padded(bytes.size()) - bytes.size());
  return XXH3_64bits_digest(&state);
}

// What is wrong with a file's header; null if nothing is.
const char* header_fault(std::span<const std::byte> bytes, const FileHeader& header, VerifyChecksums verify) {
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) return "is not a structure file";
  if (header.byte_order == kOtherByteOrder) return "was written on a machine of the other byte order; build it again here";
  if (header.version != kAccelFileVersion) return "is of another version of the format; build it again";
  if (verify == VerifyChecksums::yes && header.header_checksum != header_checksum(header)) return "the header is damaged";
  if (header.file_size != bytes.size()) return "is truncated, or something was appended";
  if (header.section_count > kMostSections || table_end(header.section_count) > bytes.size())
    return "the table of sections does not fit the file";
  return nullptr;
}

// What is wrong with one section, which must begin at `offset`; null if nothing is. Sizes are compared so that nothing
// overflows.
const char* entry_fault(const TableEntry& entry, std::uint64_t offset, std::uint64_t file_size) {
  if (entry.name[0] == 0 || entry.name[sizeof(entry.name) - 1] != 0) return "the table has a section without a name";
  if (entry.offset != offset) return "the table has sections that overlap or leave gaps";
  if (entry.size_bytes > file_size - offset || padded(entry.size_bytes) > file_size - offset)
    return "the table has a section that ends behind the file";
  if (entry.element_size == 0 || entry.size_bytes % entry.element_size != 0)
    return "the table has a section of broken elements";
  return nullptr;
}

}  // namespace

struct AccelFile::State {
  std::filesystem::path path;
  std::shared_ptr<MappedFile> mapping;
  std::vector<TableEntry> table;
  std::unique_ptr<std::atomic<bool>[]> verified;  // by section

  const TableEntry* find(std::string_view name) const {
    const auto found = std::find_if(table.begin(), table.end(), [&](const TableEntry& entry) { return entry.name == name; });
    return found == table.end() ? nullptr : &*found;
  }
};

Result<AccelFile> AccelFile::open(const std::filesystem::path& path, VerifyChecksums verify) try {
  Result<std::shared_ptr<MappedFile>> mapping = MappedFile::open(path);
  if (!mapping) return mapping.error();
  const auto state = std::make_shared<State>();
  state->path = path;
  state->mapping = *std::move(mapping);
  AccelFile file(state);

  const std::span<const std::byte> bytes = state->mapping->bytes();
  FileHeader header;
  if (bytes.size() < sizeof(header)) return file.error({}, "is not a structure file, or is truncated");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (const char* fault = header_fault(bytes, header, verify)) return file.error({}, fault);

  std::uint64_t offset = table_end(header.section_count);
  const std::span<const std::byte> table = bytes.subspan(sizeof(header), offset - sizeof(header));
  if (verify == VerifyChecksums::yes && checksum(table.data(), table.size()) != header.table_checksum)
    return file.error({}, "the table of sections is damaged");
  state->table.resize(header.section_count);
  if (!state->table.empty()) std::memcpy(state->table.data(), table.data(), state->table.size() * sizeof(TableEntry));

  for (const TableEntry& entry : state->table) {
    if (const char* fault = entry_fault(entry, offset, bytes.size())) return file.error({}, fault);
    if (state->find(entry.name) != &entry) return file.error(entry.name, "stands in the table twice");
    offset += padded(entry.size_bytes);
  }
  if (offset != bytes.size()) return file.error({}, "holds more than its table of sections says");

  state->verified = std::make_unique<std::atomic<bool>[]>(state->table.size());
  for (std::size_t i = 0; i < state->table.size(); ++i) state->verified[i] = verify == VerifyChecksums::no;
  return file;
} catch (const std::bad_alloc&) {
  return out_of_memory("opening a structure file");
}

const std::filesystem::path& AccelFile::path() const { return state_->path; }

std::uint64_t AccelFile::size_bytes() const { return state_->mapping->size(); }

std::vector<std::string> AccelFile::section_names() const {
  std::vector<std::string> names;
  for (const TableEntry& entry : state_->table) names.emplace_back(entry.name);
  return names;
}

bool AccelFile::has(std::string_view name) const { return state_->find(name) != nullptr; }

std::uint64_t AccelFile::count(std::string_view name) const {
  const TableEntry* entry = state_->find(name);
  return entry != nullptr ? entry->size_bytes / entry->element_size : 0;
}

Result<std::string> AccelFile::text(std::string_view name) const try {
  const Result<Buffer<char>> characters = array<char>(name);
  if (!characters) return characters.error();
  return std::string(characters->begin(), characters->end());
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a section");
}

Error AccelFile::error(std::string_view section, std::string_view what) const {
  const std::string place = section.empty() ? std::string() : "section '" + std::string(section) + "' ";
  return Error{state_->path.string() + ": " + place + std::string(what)};
}

Result<AccelFile::RawSection> AccelFile::take(std::string_view name, std::size_t element_size) const try {
  const TableEntry* entry = state_->find(name);
  if (entry == nullptr) return error(name, "is missing");
  if (entry->element_size != element_size)
    return error(
        name, "has elements of " + std::to_string(entry->element_size) + " bytes instead of " + std::to_string(element_size));

  std::byte* data = state_->mapping->data() + entry->offset;
  std::atomic<bool>& verified = state_->verified[entry - state_->table.data()];
  if (!verified.load(std::memory_order_relaxed)) {
    if (checksum(data, padded(entry->size_bytes)) != entry->checksum) return error(name, "is damaged: its checksum differs");
    verified.store(true, std::memory_order_relaxed);
  }
  return RawSection{data, entry->size_bytes, state_->mapping};
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a section");
}

void AccelFileWriter::add_borrowed(std::string_view name, std::span<const std::byte> bytes, std::size_t element_size) try {
  sections_.push_back({std::string(name), bytes, static_cast<std::uint32_t>(element_size), nullptr});
} catch (const std::bad_alloc&) {
  complete_ = false;
}

void AccelFileWriter::add_copied(std::string_view name, std::span<const std::byte> bytes, std::size_t element_size) try {
  auto copy = std::make_shared<std::vector<std::byte>>(bytes.begin(), bytes.end());
  sections_.push_back({std::string(name), *copy, static_cast<std::uint32_t>(element_size), copy});
} catch (const std::bad_alloc&) {
  complete_ = false;
}

Status AccelFileWriter::write(const std::filesystem::path& path) const try {
  if (!complete_) return out_of_memory("collecting the sections of a structure file");
  FileHeader header = {};
  std::uint64_t offset = table_end(sections_.size());
  std::vector<TableEntry> table((offset - sizeof(FileHeader)) / sizeof(TableEntry));  // ends in empty entries as padding
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Section& section = sections_[i];
    TableEntry& entry = table[i] = {};
    const bool good_name = !section.name.empty() && section.name.size() < sizeof(entry.name);
    const bool taken = std::any_of(table.begin(), table.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const TableEntry& other) { return section.name == other.name; });
    if (!good_name || taken) return Error{path.string() + ": '" + section.name + "' cannot be the name of a section"};
    section.name.copy(entry.name, sizeof(entry.name) - 1);
    entry.offset = offset;
    entry.size_bytes = section.bytes.size();
    entry.element_size = section.element_size;
    entry.checksum = padded_checksum(section.bytes);
    offset += padded(section.bytes.size());
  }
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kAccelFileVersion;
  header.byte_order = kByteOrder;
  header.file_size = offset;
  header.section_count = static_cast<std::uint32_t>(sections_.size());
  header.table_checksum = checksum(table.data(), table.size() * sizeof(TableEntry));
  header.header_checksum = header_checksum(header);

  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Status status = file->write(std::as_bytes(std::span(&header, 1))); !status) return status;
  if (Status status = file->write(std::as_bytes(std::span(table))); !status) return status;
  constexpr std::byte kZeros[kAlignment] = {};
  for (const Section& section : sections_) {
    if (Status status = file->write(section.bytes); !status) return status;
    const std::size_t padding = padded(section.bytes.size()) - section.bytes.size();
    if (Status status = file->write(std::span(kZeros, padding)); !status) return status;
  }
  return file->commit();
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a structure file");
}

}  // namespace accel
