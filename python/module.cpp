// The extension of the Python module `kerf`: library/kerf.h for numpy. python/kerf/__init__.py is the interface.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "library/kerf.h"

namespace py = pybind11;

namespace kerf {
namespace {

constexpr const char* kCodes[] = {"not found", "unreadable", "bad format",   "bad value", "unsupported",
                                  "empty",     "geometry",   "write failed", "cancelled"};

// kerf.Error, made by the Python side.
py::object& errorClass() {
  static py::object* const found = new py::object();
  return *found;
}

[[noreturn]] void raise(const Error& error) {
  if (PyErr_Occurred()) throw py::error_already_set();  // Ctrl-C, or an error of the progress function
  const py::object made = errorClass()(error.message(), kCodes[static_cast<int>(error.code)], error.file, error.place,
                                       error.found, error.expected, error.hint);
  PyErr_SetObject(errorClass().ptr(), made.ptr());
  throw py::error_already_set();
}

template <class T>
T valueOf(Expected<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// Looks for Ctrl-C, and calls the user's function: progress(fraction, step). A false result or an exception cancels.
// Its error, and Ctrl-C, come out of the call: raise().
class PythonProgress {
 public:
  explicit PythonProgress(py::object function) : function_(std::move(function)) {}

  Progress callback() {
    return [this](double done, std::string_view what) {
      const py::gil_scoped_acquire lock;
      if (PyErr_Occurred() || PyErr_CheckSignals() != 0) return false;
      if (function_.is_none()) return true;
      try {
        const py::object answer = function_(done, py::str(what.data(), what.size()));
        const int goes_on = answer.is_none() ? 1 : PyObject_IsTrue(answer.ptr());
        if (goes_on < 0) throw py::error_already_set();
        return goes_on != 0;
      } catch (py::error_already_set& error) {
        error.restore();
        return false;
      }
    };
  }

 private:
  py::object function_;
};

// Runs it without the interpreter's lock.
template <class Work>
auto unlocked(const Work& work) {
  const py::gil_scoped_release release;
  return work();
}

// The thread of a call.
struct Worker {
  std::thread thread;
  std::shared_ptr<std::atomic<bool>> has_ended;
  pid_t process = getpid();  // a fork has none of the threads
};

// Those that Ctrl-C or an error left behind. Guarded by the interpreter's lock.
std::vector<Worker>& leftWorkers() {
  static auto* const workers = new std::vector<Worker>();
  return *workers;
}

// Joins the ended ones, or all.
void joinLeft(bool all) {
  std::vector<Worker>& left = leftWorkers();
  const auto first = std::partition(left.begin(), left.end(), [&](const Worker& worker) {
    return worker.process != getpid() || !(all || *worker.has_ended);
  });
  std::vector<Worker> now(std::make_move_iterator(first), std::make_move_iterator(left.end()));
  left.erase(first, left.end());
  const py::gil_scoped_release release;
  for (Worker& worker : now) worker.thread.join();
}

// Runs work(progress) on a thread of its own; `function` is called here. Ctrl-C and errors of the function come out
// within 0.4 s: OpenVDB has loops of seconds that cannot be cancelled, and then ends them unheard.
// @param work  owns all that it uses.
template <class T>
T interruptible(std::function<Expected<T>(const Progress&)> work, py::object function) {
  struct Job {
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<Expected<T>> result;
    std::exception_ptr thrown;  // with a result of kCancelled
    bool is_cancelled = false;
    std::optional<std::pair<double, std::string>> report;  // waits for an answer
  };
  struct Guard {
    std::shared_ptr<Job> job;
    Worker worker;

    ~Guard() {
      if (!worker.thread.joinable()) return;
      {
        const std::lock_guard lock(job->mutex);
        job->is_cancelled = true;
      }
      job->changed.notify_all();
      leftWorkers().push_back(std::move(worker));
    }
  };
  joinLeft(false);
  const auto job = std::make_shared<Job>();
  const auto ended = std::make_shared<std::atomic<bool>>(false);
  std::thread thread([job, ended, work = std::move(work)] {
    Expected<T> result = cancelled();
    try {
      result = work([&](double done, std::string_view what) {
        std::unique_lock lock(job->mutex);
        job->report.emplace(done, what);
        job->changed.notify_all();
        job->changed.wait(lock, [&] { return job->is_cancelled || !job->report; });
        return !job->is_cancelled;
      });
    } catch (...) {
      job->thrown = std::current_exception();
    }
    {
      const std::lock_guard lock(job->mutex);
      job->result.emplace(std::move(result));
      job->changed.notify_all();
    }
    *ended = true;
  });
  Guard guard{.job = job, .worker = {.thread = std::move(thread), .has_ended = ended}};

  PythonProgress told(std::move(function));
  const Progress tell = told.callback();
  const auto wait = [&](int most_ms, const auto& until) {  // true: it has ended
    const py::gil_scoped_release release;
    std::unique_lock lock(job->mutex);
    job->changed.wait_for(lock, std::chrono::milliseconds(most_ms), until);
    return job->result.has_value();
  };
  const auto has_ended = [&] { return job->result.has_value(); };
  bool goes_on = true;
  while (!wait(50, [&] { return has_ended() || (goes_on && job->report); })) {
    std::unique_lock lock(job->mutex);
    const auto report = goes_on ? job->report : std::nullopt;
    lock.unlock();
    const bool is_fine = report ? tell(report->first, report->second) : PyErr_CheckSignals() == 0;
    goes_on = goes_on && is_fine;
    lock.lock();
    job->is_cancelled = !goes_on;
    if (report) job->report.reset();
    lock.unlock();
    job->changed.notify_all();
    if (PyErr_Occurred() && !wait(300, has_ended)) throw py::error_already_set();
  }
  guard.worker.thread.join();
  if (PyErr_Occurred()) throw py::error_already_set();
  if (job->thrown) std::rethrow_exception(job->thrown);
  return valueOf(std::move(*job->result));
}

// ---- Meshes

using SharedMesh = std::shared_ptr<Mesh>;

// A view of memory that the mesh keeps alive.
template <class Value>
py::array viewOf(const SharedMesh& mesh, const Value* data, std::size_t rows, std::size_t columns) {
  auto* const keeper = new SharedMesh(mesh);
  const py::capsule owner(keeper, [](void* kept) { delete static_cast<SharedMesh*>(kept); });
  py::array_t<Value> out({rows, columns}, {columns * sizeof(Value), sizeof(Value)}, data, owner);
  out.attr("flags").attr("writeable") = false;
  return out;
}

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
using Bytes = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

[[noreturn]] void wrongShape(const char* what, const py::array& given, const char* expected) {
  std::string shape = "shape (";
  for (py::ssize_t n = 0; n < given.ndim(); ++n) shape += (n ? ", " : "") + std::to_string(given.shape(n));
  raise({.code = Error::Code::kBadValue, .place = what, .found = shape + ")", .expected = expected});
}

SharedMesh meshOf(const Doubles& vertices, const Indices& faces, const std::optional<Bytes>& colors) {
  if (vertices.ndim() != 2 || vertices.shape(1) != 3) wrongShape("vertices", vertices, "(n, 3)");
  if (faces.ndim() != 2 || faces.shape(1) != 3) wrongShape("faces", faces, "(m, 3), triangles");
  auto out = std::make_shared<Mesh>();
  const auto count = static_cast<std::size_t>(vertices.shape(0));
  out->vertices.resize(count);
  const auto xyz = vertices.unchecked<2>();
  const auto corners = faces.unchecked<2>();
  valueOf(unlocked([&]() -> Expected<void> {
    for (std::size_t n = 0; n < count; ++n)
      for (int k = 0; k < 3; ++k) {
        const double value = xyz(static_cast<py::ssize_t>(n), k);
        if (!std::isfinite(value))
          return fail({.code = Error::Code::kBadValue,
                       .place = "vertex " + std::to_string(n),
                       .found = std::to_string(value),
                       .expected = "finite coordinates"});
        out->vertices[n][k] = value;
      }
    out->triangles.resize(static_cast<std::size_t>(faces.shape(0)));
    for (std::size_t n = 0; n < out->triangles.size(); ++n)
      for (int k = 0; k < 3; ++k) {
        const std::int64_t v = corners(static_cast<py::ssize_t>(n), k);
        if (v < 0 || v >= static_cast<std::int64_t>(count))
          return fail({.code = Error::Code::kBadValue,
                       .place = "face " + std::to_string(n),
                       .found = "vertex " + std::to_string(v),
                       .expected = "0 to " + std::to_string(count - 1)});
        out->triangles[n][static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(v);
      }
    return {};
  }));
  if (colors) {
    const bool is_rgba = colors->ndim() == 2 && colors->shape(1) == 4;
    if (!is_rgba || (static_cast<std::size_t>(colors->shape(0)) != count &&
                     static_cast<std::size_t>(colors->shape(0)) != out->triangles.size()))
      wrongShape("colors", *colors, "(n, 4) of the vertices or (m, 4) of the faces, 0 to 255");
    const auto rgba = colors->unchecked<2>();
    std::vector<Rgba8>& to =
        static_cast<std::size_t>(colors->shape(0)) == count ? out->vertex_colors : out->face_colors;
    to.resize(static_cast<std::size_t>(colors->shape(0)));
    for (std::size_t n = 0; n < to.size(); ++n)
      for (int k = 0; k < 4; ++k) to[n][static_cast<std::size_t>(k)] = rgba(static_cast<py::ssize_t>(n), k);
  }
  return out;
}

py::object colorsOf(const SharedMesh& mesh) {
  const std::vector<Rgba8>& colors = mesh->hasVertexColors() ? mesh->vertex_colors : mesh->face_colors;
  if (colors.empty()) return py::none();
  return viewOf(mesh, colors.front().data(), colors.size(), 4);
}

// ---- Cuts

std::vector<PathPose> posesOf(const Doubles& poses, const std::optional<Doubles>& times) {
  constexpr double kUsualFeed = 5;  // mm/s
  if (poses.ndim() != 2 || (poses.shape(1) != 3 && poses.shape(1) != 7))
    wrongShape("path", poses, "(n, 3): x, y, z of the tip in mm; or (n, 7): also the attitude qw, qx, qy, qz");
  const auto rows = poses.unchecked<2>();
  std::vector<PathPose> out(static_cast<std::size_t>(poses.shape(0)));
  if (times && (times->ndim() != 1 || static_cast<std::size_t>(times->shape(0)) != out.size()))
    wrongShape("times", *times, "(n,): s, increasing");
  for (std::size_t n = 0; n < out.size(); ++n) {
    const auto row = static_cast<py::ssize_t>(n);
    Rigid3& pose = out[n].T_object_tool;
    pose.translation = Vec3d(rows(row, 0), rows(row, 1), rows(row, 2));
    if (poses.shape(1) == 7) pose.rotation = Eigen::Quaterniond(rows(row, 3), rows(row, 4), rows(row, 5), rows(row, 6));
    if (times)
      out[n].t = times->unchecked<1>()(row);
    else if (n > 0)
      out[n].t =
          out[n - 1].t + std::max(1e-3, (pose.translation - out[n - 1].T_object_tool.translation).norm() / kUsualFeed);
  }
  return out;
}

py::array forcesOf(const RunSeries& series) {
  struct Row {
    float t_s, contact_N, hand_N, speed, drive_load, temperature_C, removed_mm3;
  };
  const std::vector<const char*> names{"t_s",        "contact_N",     "hand_N",     "speed",
                                       "drive_load", "temperature_C", "removed_mm3"};
  py::list fields;
  for (const char* const name : names) fields.append(py::make_tuple(name, "<f4"));
  py::array out(py::dtype::from_args(fields), std::vector<py::ssize_t>{static_cast<py::ssize_t>(series.size())});
  auto* const rows = static_cast<Row*>(out.mutable_data());
  const auto at = [](const std::vector<float>& values, std::size_t n) { return n < values.size() ? values[n] : 0.0f; };
  for (std::size_t n = 0; n < series.size(); ++n)
    rows[n] = {series.t_s[n],
               at(series.contact_N, n),
               at(series.hand_N, n),
               at(series.speed, n),
               at(series.drive_load, n),
               at(series.temperature_C, n),
               at(series.removed_mm3, n)};
  return out;
}

Vec3d vectorOf(const std::array<double, 3>& given) { return {given[0], given[1], given[2]}; }

BakeOptions bakeOptions(double voxel, const std::string& unit, const std::string& base,
                        const std::optional<double>& base_height, const std::string& close, bool occlusal_plane,
                        const std::optional<std::array<double, 3>>& base_direction) {
  BakeOptions out;
  out.unit = unit;
  out.voxelize.voxel_mm = voxel;
  out.voxel_is_given = true;
  out.close.base_height_mm = base_height;
  out.close.find_occlusal_plane = occlusal_plane;
  if (base_direction) out.close.base_direction = vectorOf(*base_direction);
  if (base == "full" || base == "horseshoe")
    out.close.base_style = base == "full" ? BaseStyle::kFull : BaseStyle::kHorseshoe;
  else if (!base.empty())
    raise({.code = Error::Code::kBadValue,
           .place = "base",
           .found = "\"" + base + "\"",
           .expected = "\"horseshoe\" or \"full\""});
  out.close.base_is_asked = !base.empty() || base_height || occlusal_plane || base_direction;
  if (close == "auto" || close.empty())
    out.close.mode = CloseMode::kAuto;
  else if (close == "base")
    out.close.mode = CloseMode::kBase;
  else if (close == "repair")
    out.close.mode = CloseMode::kRepair;
  else if (close == "wrap")
    out.close.mode = CloseMode::kWrap;
  else
    raise({.code = Error::Code::kBadValue,
           .place = "close",
           .found = "\"" + close + "\"",
           .expected = "\"auto\", \"base\", \"repair\" or \"wrap\""});
  return out;
}

py::dict manifestOf(const CaseManifest& m) {
  py::dict out;
  out["id"] = m.id;
  out["exact"] = m.exact;
  out["changes"] = m.changes;
  out["voxel_mm"] = m.voxel_mm;
  out["volume_mm3"] = m.solid_volume_mm3;
  out["area_mm2"] = m.solid_area_mm2;
  out["vertices"] = m.solid_vertices;
  out["triangles"] = m.solid_triangles;
  out["closing"] = m.closing;
  if (!m.sources.empty()) {
    out["unit"] = m.sources.front().unit;
    out["unit_reason"] = m.sources.front().unit_reason;
  }
  return out;
}

}  // namespace
}  // namespace kerf

using namespace kerf;  // NOLINT: the module's own names follow

PYBIND11_MODULE(_kerf, m) {
  py::module_::import("atexit").attr("register")(py::cpp_function([] { joinLeft(true); }));
  m.def("set_error", [](py::object error) { errorClass() = std::move(error); });

  py::class_<Mesh, SharedMesh>(m, "Mesh", py::dynamic_attr())
      .def(py::init(&meshOf), py::arg("vertices"), py::arg("faces"), py::arg("colors") = py::none())
      .def_property_readonly("vertices",
                             [](const SharedMesh& mesh) {
                               return viewOf(mesh, mesh->vertices.empty() ? nullptr : mesh->vertices.front().data(),
                                             mesh->vertices.size(), 3);
                             })
      .def_property_readonly("faces",
                             [](const SharedMesh& mesh) {
                               return viewOf(mesh, mesh->triangles.empty() ? nullptr : mesh->triangles.front().data(),
                                             mesh->triangles.size(), 3);
                             })
      .def_property_readonly("colors", &colorsOf)
      .def("write", [](const SharedMesh& mesh, const std::string& path) {
        valueOf(unlocked([&] { return writeMesh(path, *mesh); }));
      });

  m.def(
      "read",
      [](const std::string& path, py::object progress) {
        PythonProgress told(std::move(progress));
        auto file = valueOf(unlocked([&] { return readMesh(path, told.callback()); }));
        py::object mesh = py::cast(std::make_shared<Mesh>(std::move(file.mesh)));
        mesh.attr("unit") = file.declared_unit;
        mesh.attr("notes") = file.notes;
        return mesh;
      },
      py::arg("path"), py::arg("progress") = py::none());

  py::class_<MeshReport>(m, "Check")
      .def_readonly("ready", &MeshReport::print_ready)
      .def_readonly("reasons", &MeshReport::reasons)
      .def_readonly("volume_mm3", &MeshReport::volume)
      .def_readonly("area_mm2", &MeshReport::area)
      .def_readonly("pieces", &MeshReport::pieces)
      .def_readonly("cavities", &MeshReport::cavities)
      .def("json", [](const MeshReport& report) { return kerf::toJson(report); })
      .def("__str__", [](const MeshReport& report) { return kerf::describe(report); });
  m.def("check", [](const SharedMesh& mesh) { return unlocked([&] { return checkMesh(*mesh); }); });

  py::class_<WorkpieceCut>(m, "Cut")
      .def_property_readonly(
          "mesh",
          [](const WorkpieceCut& cut) { return unlocked([&] { return std::make_shared<Mesh>(cut.post_op.mesh); }); })
      .def_property_readonly("is_cut",
                             [](const WorkpieceCut& cut) {
                               py::array_t<bool> out(static_cast<py::ssize_t>(cut.post_op.is_cut.size()));
                               std::copy(cut.post_op.is_cut.begin(), cut.post_op.is_cut.end(), out.mutable_data());
                               return out;
                             })
      .def_readonly("removed_mm3", &WorkpieceCut::removed_mm3)
      .def_property_readonly("wall_um",
                             [](const WorkpieceCut& cut) -> std::optional<double> {
                               if (cut.accuracy.vertices == 0) return std::nullopt;
                               return 1e3 * cut.accuracy.max_mm;
                             })
      .def_property_readonly("warnings",
                             [](const WorkpieceCut& cut) {
                               std::vector<std::string> out;
                               for (const CutRemark& remark : cut.remarks)
                                 if (remark.is_warning) out.push_back(remark.text);
                               return out;
                             })
      .def_property_readonly("notes",
                             [](const WorkpieceCut& cut) {
                               std::vector<std::string> out;
                               for (const CutRemark& remark : cut.remarks)
                                 if (!remark.is_warning) out.push_back(remark.text);
                               return out;
                             })
      .def_property_readonly(
          "forces", [](const WorkpieceCut& cut) { return forcesOf(valueOf(unlocked([&] { return cut.series(); }))); })
      .def("save", [](const WorkpieceCut& cut, const std::string& folder) {
        valueOf(unlocked([&] { return cut.save(folder); }));
      });

  py::class_<Workpiece>(m, "Case")
      .def_property_readonly("solid",
                             [](const Workpiece& model) {
                               return std::make_shared<Mesh>(valueOf(unlocked([&] { return model.solid(); })));
                             })
      .def_property_readonly("report", [](const Workpiece& model) { return manifestOf(model.manifest()); })
      .def_property_readonly("warnings", [](const Workpiece& model) { return model.warnings(); })
      .def_property_readonly("folder", [](const Workpiece& model) { return model.folder().string(); })
      .def("distance",
           [](const Workpiece& model, const Doubles& points) {
             if (points.ndim() != 2 || points.shape(1) != 3) wrongShape("points", points, "(n, 3)");
             const auto xyz = points.unchecked<2>();
             std::vector<Vec3d> at(static_cast<std::size_t>(points.shape(0)));
             for (std::size_t n = 0; n < at.size(); ++n)
               for (int k = 0; k < 3; ++k) at[n][k] = xyz(static_cast<py::ssize_t>(n), k);
             const auto found = valueOf(unlocked([&] { return model.distance(at); }));
             return py::array_t<double>(static_cast<py::ssize_t>(found.size()), found.data());
           })
      .def("save",
           [](Workpiece& model, const std::string& folder) { valueOf(unlocked([&] { return model.save(folder); })); })
      .def(
          "_cut",
          [](const Workpiece& model, const std::string& id, const std::string& toml, py::object path,
             const std::optional<Doubles>& times, const std::optional<double>& force, py::object progress) {
            const ToolChoice tool{id, toml};
            const PathChoice way = py::isinstance<py::str>(path)
                                       ? PathChoice::file(path.cast<std::string>())
                                       : PathChoice::ofPoses(posesOf(path.cast<Doubles>(), times));
            CutRequest request;
            if (force) {
              request.hand.emplace();
              request.hand->hand = HandKind::kForce;
              request.hand->force.force = *force;
            }
            PythonProgress told(std::move(progress));
            return valueOf(unlocked([&] { return model.cut(tool, way, request, told.callback()); }));
          },
          py::arg("id"), py::arg("toml"), py::arg("path"), py::arg("times"), py::arg("force"), py::arg("progress"));

  m.def(
      "export",
      [](const std::string& folder, py::object progress) {
        return interruptible<SharedMesh>(
            [folder](const Progress& told) -> Expected<SharedMesh> {
              KERF_TRY(found, exportBundle(folder, {}, told));
              Mesh& whole = found.post_op.mesh;
              if (std::any_of(found.pieces.begin(), found.pieces.end(), [](const auto& p) { return p.isMoved(); })) {
                KERF_TRY(pieces, placedPieces(whole, found.pieces, false, found.names));
                whole = together(pieces);
              }
              return std::make_shared<Mesh>(std::move(whole));
            },
            std::move(progress));
      },
      py::arg("folder"), py::arg("progress") = py::none());
  m.def("open", [](const std::string& folder) { return valueOf(unlocked([&] { return Workpiece::open(folder); })); });
  m.def(
      "bake",
      [](const SharedMesh& mesh, double voxel, const std::string& unit, const std::string& base,
         const std::optional<double>& base_height, const std::string& close, bool occlusal_plane,
         const std::optional<std::array<double, 3>>& base_direction, py::object progress) {
        const BakeOptions options = bakeOptions(voxel, unit, base, base_height, close, occlusal_plane, base_direction);
        return interruptible<Workpiece>(
            [mesh, options](const Progress& told) { return Workpiece::bake(*mesh, options, told); },
            std::move(progress));
      },
      py::arg("mesh"), py::arg("voxel"), py::arg("unit"), py::arg("base"), py::arg("base_height"), py::arg("close"),
      py::arg("occlusal_plane"), py::arg("base_direction"), py::arg("progress"));
  m.def("find_tool", [](const std::string& id) {
    return valueOf(unlocked([&] { return findToolFile(id, defaultToolFolders()); })).string();
  });
  m.def("tool_ids", [] {
    std::vector<std::string> out;
    for (const ToolListing& listing : unlocked([] { return listTools(defaultToolFolders()); }))
      if (listing.tool) out.push_back(listing.tool->id);
    return out;
  });
}
