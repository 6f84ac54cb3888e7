// Curve reconstruction by CGAL's optimal transportation: transport SAMPLES TOLERANCE CHOICES
//
// SAMPLES is a file of pairs of doubles, TOLERANCE the distance in the sense of Wasserstein at which to
// stop, CHOICES the number of edge collapses to choose from at random, 0 for a queue of all. Writes the
// numbers of vertices and edges, then the vertices, then the edges by the numbers of their vertices.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Optimal_transportation_reconstruction_2.h>
#include <CGAL/version.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;

int main(int argc, char **argv) {
  if (argc == 1) return std::printf("%s\n", CGAL_VERSION_STR) < 0;
  if (argc != 4) return 2;
  std::ifstream file(argv[1], std::ios::binary);
  std::vector<Point> samples;
  for (double xy[2]; file.read(reinterpret_cast<char *>(xy), sizeof xy);) samples.emplace_back(xy[0], xy[1]);

  CGAL::Optimal_transportation_reconstruction_2<Kernel> reconstruction(samples);
  reconstruction.set_random_sample_size(std::strtoul(argv[3], nullptr, 10));
  reconstruction.run_under_wasserstein_tolerance(std::strtod(argv[2], nullptr));

  std::vector<Point> vertices;
  std::vector<std::size_t> alone;
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  reconstruction.indexed_output(std::back_inserter(vertices), std::back_inserter(alone), std::back_inserter(edges));
  std::printf("%zu %zu\n", vertices.size(), edges.size());
  for (const Point &p : vertices) std::printf("%.17g %.17g\n", p.x(), p.y());
  for (const auto &edge : edges) std::printf("%zu %zu\n", edge.first, edge.second);
}
