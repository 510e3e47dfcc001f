// PCL's EuclideanClusterExtraction as a detector of scanbench: what stands higher than `ground_m` above the road, clustered.

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include "scanbench.hpp"

namespace {

using PointCloud = pcl::PointCloud<pcl::PointXYZ>;

// The points above the level of the road, and which they are.
std::pair<PointCloud::Ptr, std::vector<std::size_t>> above(const scanbench::Cloud& cloud, double min_z_m) {
    auto kept = std::make_pair(PointCloud::Ptr(new PointCloud), std::vector<std::size_t>());
    for (std::size_t i = 0; i < cloud.n_points; ++i) {
        if (cloud.z_m[i] < min_z_m) continue;
        kept.first->push_back({cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]});
        kept.second.push_back(i);
    }
    return kept;
}

}  // namespace

int main() {
    return scanbench::serve(
        "euclidean",
        [](const scanbench::Configuration& configuration) -> scanbench::Detect {
            const auto& given = configuration.parameters;
            pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
            extraction.setClusterTolerance(given.number("tolerance_m", 0.5));
            extraction.setMinClusterSize(static_cast<pcl::uindex_t>(given.integer("min_points", 10)));
            extraction.setMaxClusterSize(static_cast<pcl::uindex_t>(given.integer("max_points", 25000)));
            const double min_z_m = given.number("ground_m", 0.3) - configuration.sensor_height_m.value_or(1.73);

            return [extraction, min_z_m](const scanbench::Cloud& cloud) mutable {
                scanbench::Detections found;
                scanbench::StageClock clock;
                found.clusters.assign(cloud.n_points, 0);
                const auto [kept, places] = above(cloud, min_z_m);
                clock.end("ground");
                if (!kept->empty()) {
                    pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
                    tree->setInputCloud(kept);
                    extraction.setSearchMethod(tree);
                    extraction.setInputCloud(kept);
                    std::vector<pcl::PointIndices> clusters;
                    extraction.extract(clusters);
                    for (std::size_t cluster = 0; cluster < clusters.size(); ++cluster) {
                        for (const auto index : clusters[cluster].indices) {
                            found.clusters[places[static_cast<std::size_t>(index)]] = static_cast<std::uint32_t>(cluster + 1);
                        }
                    }
                }
                clock.end("clusters");
                found.stages = clock.stages();
                return found;
            };
        },
        PCL_VERSION_PRETTY);
}
