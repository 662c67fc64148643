#include "bearing_calibration/planning/region.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/linestring.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/geometries/segment.hpp>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

namespace geometry = boost::geometry;
using Point = geometry::model::d2::point_xy<double>;
using Polygon = geometry::model::polygon<Point>;
using Line = geometry::model::linestring<Point>;

/// Clearance of a way that leaves the region past an inward corner, between ends that lie inside.
constexpr double kOutsideBetween_m = 1e-9;

Point pointFrom(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

Polygon polygonFrom(const std::vector<Eigen::Vector2d>& corners) {
  Polygon polygon;
  for (const Eigen::Vector2d& corner : corners) geometry::append(polygon, pointFrom(corner));
  geometry::correct(polygon);  // closed, and in the order that the library wants
  return polygon;
}

}  // namespace

void Region::declare(Parameters& params) {
  constexpr std::size_t kLeastCorners = 3;
  params.list("region/polygon", 2, polygon_m,
              [](const auto& row) { return Eigen::Vector2d(row[0], row[1]); });
  params.number("region/radius", radius_m, 0.0, plausible::kFarthest_m);
  params.that(!polygon_m.empty() || radius_m >= plausible::kShortest_m,
              formatted("region/radius must be at least %g without region/polygon",
                        plausible::kShortest_m));
  if (polygon_m.empty()) return;
  const bool is_near =
      std::all_of(polygon_m.begin(), polygon_m.end(), [](const Eigen::Vector2d& corner) {
        return corner.cwiseAbs().maxCoeff() <= plausible::kFarthest_m;
      });
  params.that(is_near, "region/polygon must lie within 1000 m of the start");
  params.that(
      polygon_m.size() >= kLeastCorners,
      "region/polygon must have at least 3 corners, but has " + std::to_string(polygon_m.size()));
  if (!is_near || polygon_m.size() < kLeastCorners) return;
  params.that(geometry::is_valid(polygonFrom(polygon_m)), "region/polygon must not cross itself");
  params.that(clearance(Eigen::Vector2d::Zero()) > 0.0,
              "region/polygon must contain the start, (0, 0)");
}

double Region::clearance(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  if (polygon_m.empty()) return radius_m - std::max(from.norm(), to.norm());
  const Polygon polygon = polygonFrom(polygon_m);
  const geometry::model::segment<Point> way(pointFrom(from), pointFrom(to));
  const Line border(polygon.outer().begin(), polygon.outer().end());
  const auto to_border = [&border](const auto& what) { return geometry::distance(what, border); };
  if (!geometry::within(pointFrom(from), polygon)) return -to_border(pointFrom(from));
  if (!geometry::within(pointFrom(to), polygon)) return -to_border(pointFrom(to));
  const double clearance_m = to_border(way);
  return clearance_m > 0.0 ? clearance_m : -kOutsideBetween_m;
}

}  // namespace bearing_calibration::core
