#include "ui/app/program/manual.h"

#include <fmt/format.h>

#include <cstdio>
#include <string_view>
#include <system_error>

#include "geometry/base/atomic_file.h"
#include "geometry/base/text.h"
#include "geometry/base/version.h"
#include "ui/app/program/command_line.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWriteManual = "--write-manual";

// Escapes troff requests and special characters.
std::string troff(std::string_view text) {
  std::string out;
  bool at_line_start = true;

  for (const char c : text) {
    if (at_line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    at_line_start = c == '\n';
  }
  return out;
}

bool isOptionGroup(const CLI::App& app) { return app.get_name().empty(); }

// Options of the command, then of its option groups, which CLI11 keeps as commands without a name.
std::vector<const CLI::Option*> shownOptions(const CLI::App& app) {
  std::vector<const CLI::Option*> out =
      app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });

  for (const CLI::App* group : app.get_subcommands([](const CLI::App* group) { return isOptionGroup(*group); })) {
    const std::vector<const CLI::Option*> more = group->get_options(
        [](const CLI::Option* option) { return !option->get_group().empty() && !option->check_lname("help"); });
    out.insert(out.end(), more.begin(), more.end());
  }
  return out;
}

std::vector<const CLI::App*> shownCommands(const CLI::App& app) {
  return app.get_subcommands(
      [](const CLI::App* command) { return !command->get_group().empty() && !isOptionGroup(*command); });
}

// The --help text of an option, with its default.
std::string explained(const CLI::Option& option) {
  const std::string standard = option.get_default_str();
  return option.get_description() + (standard.empty() ? "" : " (default " + standard + ")");
}

// "-o, --output FILE": the spellings of an option and its argument.
std::string spelling(const CLI::Option& option) {
  if (option.get_positional()) return option.get_name();

  std::string out;
  for (const std::string& name : option.get_snames()) out += (out.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames()) out += (out.empty() ? "--" : ", --") + name;
  if (option.get_expected_max() > 0) {
    const std::string type = option.get_type_name();
    out += " " + (type.empty() ? "VALUE" : type);
  }
  return out;
}

std::string pageName(const CLI::App& app, const CLI::App* command) {
  return command ? app.get_name() + "-" + command->get_name() : app.get_name();
}

void appendOptions(const CLI::App& app, std::string& out) {
  bool has_title = false;
  for (const CLI::Option* option : shownOptions(app)) {
    if (!has_title) out += ".SH OPTIONS\n";
    has_title = true;
    out += fmt::format(".TP\n.B {}\n{}\n", troff(spelling(*option)), troff(explained(*option)));
  }
}

// The lines of the text stay as they are.
std::string verbatim(const std::string& text) { return fmt::format(".nf\n{}\n.fi\n", troff(text)); }

std::string inCapitals(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

std::string firstSentence(const std::string& text) {
  const std::size_t end = std::min(text.find(". "), text.find('\n'));
  std::string out = text.substr(0, end);
  if (!out.empty() && out.back() == '.') out.pop_back();
  return out;
}

// Commands within a command ("kerf tool check") stand in its page.
void appendCommands(const CLI::App& app, std::string& out) {
  const std::vector<const CLI::App*> commands = shownCommands(app);
  if (commands.empty()) return;

  out += ".SH COMMANDS\n";
  for (const CLI::App* command : commands) {
    out += fmt::format(".TP\n.B {}\n{}\n", troff(command->get_name()), troff(command->get_description()));
    for (const CLI::Option* option : shownOptions(*command)) {
      if (!app.get_parent()) break;  // on the program's page: each command has its own
      out += fmt::format(".RS\n.TP\n.B {}\n{}\n.RE\n", troff(spelling(*option)), troff(explained(*option)));
    }
  }
}

std::string page(const CLI::App& program, const CLI::App* command, const std::string& version) {
  const CLI::App& app = command ? *command : program;
  const std::string name = pageName(program, command);

  std::string out = fmt::format(".TH {} 1 \"\" \"{}\"\n", troff(inCapitals(name)), troff(version));
  out += fmt::format(".SH NAME\n{} \\- {}\n", troff(name), troff(firstSentence(app.get_description())));

  std::string synopsis = command ? program.get_name() + " " + command->get_name() : program.get_name();
  if (!shownCommands(app).empty()) synopsis += " COMMAND";
  synopsis += " [OPTIONS]";
  for (const CLI::Option* option : shownOptions(app))
    if (option->get_positional()) synopsis += " " + option->get_name();
  out += fmt::format(".SH SYNOPSIS\n.B {}\n", troff(synopsis));

  out += fmt::format(".SH DESCRIPTION\n{}\n", troff(app.get_description()));
  appendCommands(app, out);
  appendOptions(app, out);
  // The footer of a command has examples; that of a program, general remarks.
  const std::string footer = app.get_footer().empty() ? "" : verbatim(app.get_footer());
  if (command && !footer.empty()) out += ".SH EXAMPLES\n" + footer;

  out += ".SH EXIT STATUS\n" + verbatim(kExitCodes);
  out += ".SH NOTES\n" + (command || footer.empty() ? "" : footer + ".PP\n");
  out += "Kerf is a tool for training and lab work. It is not a medical device.\n";
  return out;
}

std::string topicPage(const std::string& program, const HelpPage& topic, const std::string& version) {
  const std::string name = program + "-" + topic.name;
  std::string out = fmt::format(".TH {} 7 \"\" \"{}\"\n", troff(inCapitals(name)), troff(version));
  out += fmt::format(".SH NAME\n{} \\- {}\n", troff(name), troff(topic.summary));

  for (const HelpSection& section : topic.sections) {
    out += fmt::format(".SH {}\n{}", troff(inCapitals(section.title)), troff(section.text));
    if (!section.text.empty()) out += "\n";
    for (const HelpEntry& entry : section.entries)
      out += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", troff(entry.term),
                         entry.note.empty() ? "" : " (" + troff(entry.note) + ")", troff(entry.text));
  }
  return out;
}

// Words that may follow a command: its commands and the long names of its options.
std::string words(const CLI::App& app) {
  std::string out;
  for (const CLI::App* command : shownCommands(app)) out += (out.empty() ? "" : " ") + command->get_name();
  for (const CLI::Option* option : shownOptions(app))
    for (const std::string& name : option->get_lnames()) out += (out.empty() ? "--" : " --") + name;
  return out;
}

// Words that may follow the command `help`.
std::string helpWords(const CLI::App& app, std::span<const HelpPage> topics) {
  std::string out;
  for (const CLI::App* command : shownCommands(app)) out += command->get_name() + " ";
  for (const HelpPage& topic : topics) out += topic.name + " ";
  return out + "--help";
}

// One case for each command: "tool) words=...;;", and "tool\ check)" for those within.
std::string bashCases(const CLI::App& app, const std::string& prefix) {
  std::string out;
  for (const CLI::App* command : shownCommands(app)) {
    const std::string path = prefix + command->get_name();
    out += bashCases(*command, path + " ");
    out += fmt::format("    \"{}\"*) words=\"{}\" ;;\n", path, words(*command));
  }
  return out;
}

// Completes commands and options from the table, other words as file names.
std::string bashCompletion(const CLI::App& app, std::span<const HelpPage> topics) {
  const std::string function = "_" + std::string(app.get_name() == "kerf" ? "kerf" : "kerf_sim");
  std::string out = fmt::format("# Completion of {} for bash, made by the program itself.\n", app.get_name());

  out += function + "() {\n";
  out += "  local current=${COMP_WORDS[COMP_CWORD]} typed=\"${COMP_WORDS[*]:1:COMP_CWORD-1}\" words\n";
  out += "  case \"$typed\" in\n";
  if (!topics.empty()) out += fmt::format("    \"help\"*) words=\"{}\" ;;\n", helpWords(app, topics));
  out += bashCases(app, "");
  out += fmt::format("    *) words=\"{}\" ;;\n  esac\n", words(app));
  out += "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n";
  out += "  if [ ${#COMPREPLY[@]} -eq 0 ]; then\n";
  out += "    mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n  fi\n}\n";
  out += fmt::format("complete -o filenames -F {} {}\n", function, app.get_name());
  return out;
}

// zsh loads the bash function through bashcompinit.
std::string zshCompletion(const CLI::App& app, std::span<const HelpPage> topics) {
  return fmt::format("#compdef {}\n# Completion of {} for zsh, made by the program itself.\n", app.get_name(),
                     app.get_name()) +
         "autoload -U +X bashcompinit && bashcompinit\n" + bashCompletion(app, topics);
}

std::string fishQuoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

void appendFish(const CLI::App& app, const std::string& program, const std::string& condition, std::string& out) {
  const std::string when = condition.empty() ? "" : " -n " + fishQuoted(condition);
  for (const CLI::App* command : shownCommands(app))
    out += fmt::format("complete -c {}{} -f -a {} -d {}\n", program,
                       condition.empty() ? " -n '__fish_use_subcommand'" : when, command->get_name(),
                       fishQuoted(firstSentence(command->get_description())));
  for (const CLI::Option* option : shownOptions(app))
    for (const std::string& name : option->get_lnames())
      out += fmt::format("complete -c {}{} -l {}{} -d {}\n", program, when, name,
                         option->get_expected_max() > 0 ? " -r" : "",
                         fishQuoted(firstSentence(option->get_description())));
  for (const CLI::App* command : shownCommands(app))
    appendFish(*command, program, "__fish_seen_subcommand_from " + command->get_name(), out);
}

std::string fishCompletion(const CLI::App& app, std::span<const HelpPage> topics) {
  std::string out = fmt::format("# Completion of {} for fish, made by the program itself.\n", app.get_name());
  appendFish(app, app.get_name(), "", out);
  if (!topics.empty())
    out += fmt::format("complete -c {} -n '__fish_seen_subcommand_from help' -f -a {}\n", app.get_name(),
                       fishQuoted(helpWords(app, topics)));
  return out;
}

}  // namespace

std::vector<ManualFile> manualOf(const CLI::App& app, const std::string& version, std::span<const HelpPage> topics) {
  std::vector<ManualFile> out;
  const std::string name = app.get_name();

  out.push_back({"man/man1/" + name + ".1", page(app, nullptr, version)});
  for (const CLI::App* command : shownCommands(app))
    out.push_back({"man/man1/" + pageName(app, command) + ".1", page(app, command, version)});
  for (const HelpPage& topic : topics)
    out.push_back({"man/man7/" + name + "-" + topic.name + ".7", topicPage(name, topic, version)});

  out.push_back({"bash-completion/completions/" + name, bashCompletion(app, topics)});
  out.push_back({"zsh/site-functions/_" + name, zshCompletion(app, topics)});
  out.push_back({"fish/vendor_completions.d/" + name + ".fish", fishCompletion(app, topics)});
  return out;
}

Expected<void> writeManual(const std::vector<ManualFile>& files, const fs::path& share) {
  for (const ManualFile& file : files) {
    const fs::path path = share / file.path;
    std::error_code failed;
    fs::create_directories(path.parent_path(), failed);

    KERF_TRY(out, AtomicFile::create(path));
    out.stream() << file.text;
    KERF_CHECK(out.commit());
  }
  return {};
}

bool isManualRequest(int argc, const char* const* argv) {
  return argc == 3 && std::string_view(argv[1]) == kWriteManual;
}

int answerManualRequest(const CLI::App& app, const char* folder, std::span<const HelpPage> topics) {
  const Expected<void> written = writeManual(manualOf(app, std::string("Kerf ") + kVersion, topics), folder);
  if (written) return 0;
  printText(stderr, "{}: {}\n", app.get_name(), printable(written.error().message()));
  return 1;
}

}  // namespace kerf
