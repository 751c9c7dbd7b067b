#pragma once

#include "daemon/jobs/job.h"
#include "daemon/json/json.h"

#include <filesystem>
#include <string>

namespace voidpath::daemon {

/// Begins the name of an upload that is not complete, or has not got its own name yet.
inline constexpr std::string_view kUploadPrefix = ".voidpath-upload-";

/// One row of the history, with the fields that `voidpath history --json` promises.
Json history_json(const PrintRecord& record);
/// The same, one line of CSV; and its header.
std::string history_csv(const PrintRecord& record);
std::string history_csv_header();

/// Moves the job's input to `done` or `failed` inside its watched folder, if it is still the file that was
/// taken in, and writes NAME.report.json and NAME.report.txt there. An input that was moved before, by a
/// run that ended there, is found again. Names that are taken, by an input or by another print's reports, get
/// a number. Updates job.location.
/// Throws std::filesystem::filesystem_error, std::runtime_error.
void file_input(Job& job, const std::string& subfolder, const PrintRecord& record);

/// What file_input() moved, by the name it was dropped under: its report tells. The file's own name if there
/// is no report beside it.
std::string name_when_dropped(const std::filesystem::path& input);

/// `wanted`, or with a number before its extension when that is taken.
std::filesystem::path free_name(const std::filesystem::path& wanted);

}  // namespace voidpath::daemon
