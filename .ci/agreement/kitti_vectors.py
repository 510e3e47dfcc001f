"""Makes the numbers that hold the protocol kitti-object to KITTI's development kit: what the kit says of made-up scans.

    kitti_vectors.py KIT FOLDER

KIT is the folder cpp of the kit (devkit_object.zip or a copy), with evaluate_object.cpp; g++ and Boost have to be there.
FOLDER has CASE.labels.txt and CASE.results.txt for every case (lines of KITTI's tracking layout, so that a case is one
file), and gets CASE.kit.csv: the averages that the kit's precisions at 41 recalls have. Nothing of the kit is kept.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

DEMANDS = {
    "strict": "{{0.7, 0.5, 0.5}, {0.7, 0.5, 0.5}, {0.7, 0.5, 0.5}}",
    "loose": "{{0.7, 0.5, 0.5}, {0.5, 0.25, 0.25}, {0.5, 0.25, 0.25}}",
}

# Calls the kit's own functions, scan by scan as its main does, and prints averages of what they give.
DRIVER = r"""
#define main main_of_the_kit
#include "evaluate_object.cpp"
#undef main

static void print(int kind, const char *plane, const char *level, const char *what, const vector<double> &values) {
  double r11 = 0, r40 = 0;
  for (int it = 0; it <= 40; it += 4) r11 += values[it];
  for (int it = 1; it <= 40; it++) r40 += values[it];
  printf("%s,%s,%s,%s,%.12g,%.12g\n", CLASS_NAMES[kind].c_str(), plane, level, what, r11 / 11, r40 / 40);
}

int main(int, char **arguments) {
  initGlobals();
  bool headings = true;
  vector<bool> seen[3] = {vector<bool>(3, false), vector<bool>(3, false), vector<bool>(3, false)};
  vector<vector<tGroundtruth>> labels;
  vector<vector<tDetection>> results;
  for (int scan = 0; scan < atoi(arguments[3]); scan++) {
    char name[64];
    sprintf(name, "/%06d.txt", scan);
    bool is_label, is_result;
    labels.push_back(loadGroundtruth(arguments[1] + string(name), is_label));
    results.push_back(loadDetections(arguments[2] + string(name), headings, seen[0], seen[1], seen[2], is_result));
    if (!is_label || !is_result) return 1;
  }
  double (*overlaps[3])(tDetection, tGroundtruth, int32_t) = {imageBoxOverlap, groundBoxOverlap, box3DOverlap};
  const char *planes[3] = {"2d", "bev", "3d"}, *levels[3] = {"easy", "moderate", "hard"};
  FILE *nowhere = fopen("/dev/null", "w");
  for (int plane = 0; plane < 3; plane++)
    for (int kind = 0; kind < 3; kind++)
      for (int level = 0; seen[plane][kind] && level < 3; level++) {
        vector<double> precision, similarity;
        eval_class(nowhere, nowhere, (CLASSES)kind, labels, results, plane == 0 && headings, overlaps[plane],
                   precision, similarity, (DIFFICULTY)level, (METRIC)plane);
        print(kind, planes[plane], levels[level], "ap", precision);
        if (!similarity.empty()) print(kind, planes[plane], levels[level], "aos", similarity);
      }
}
"""


def built(kit: Path, demand: str, source: Path) -> Path:
    source.mkdir()
    text = re.sub(r"(?m)^const double MIN_OVERLAP.*$", f"const double MIN_OVERLAP[3][3] = {DEMANDS[demand]};",
                  (kit / "evaluate_object.cpp").read_text())
    (source / "evaluate_object.cpp").write_text(text)
    (source / "mail.h").write_text((kit / "mail.h").read_text())
    (source / "driver.cpp").write_text(DRIVER)
    subprocess.run(["g++", "-O3", "-DNDEBUG", "-w", "-o", source / "driver", source / "driver.cpp"], check=True)
    return source / "driver"


def write_numbers(programs: dict[str, Path], labels: Path, workplace: Path) -> None:
    results = labels.with_name(labels.name.replace(".labels.", ".results."))
    lines = {name: [it.split(" ", 2) for it in path.read_text().splitlines()]
             for name, path in (("labels", labels), ("results", results))}  # fmt: skip
    n_scans = 1 + max(int(scan) for of_file in lines.values() for scan, *_ in of_file)
    for name, of_file in lines.items():
        (workplace / name).mkdir(exist_ok=True)
        for number in range(n_scans):
            text = "".join(f"{rest}\n" for scan, _track, rest in of_file if int(scan) == number)
            (workplace / name / f"{number:06}.txt").write_text(text)
    numbers = "demand,class,plane,difficulty,average,r11,r40\n"
    for demand, program in programs.items():
        command = [program, workplace / "labels", workplace / "results", str(n_scans)]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        numbers += "".join(f"{demand},{it}\n" for it in printed.splitlines())
    labels.with_name(labels.name.replace(".labels.txt", ".kit.csv")).write_text(numbers)


def main(kit: Path, folder: Path) -> None:
    with tempfile.TemporaryDirectory() as workplace:
        programs = {demand: built(kit, demand, Path(workplace, demand)) for demand in DEMANDS}
        for labels in sorted(folder.glob("*.labels.txt")):
            write_numbers(programs, labels, Path(workplace))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
