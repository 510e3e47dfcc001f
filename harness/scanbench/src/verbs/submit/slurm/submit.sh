#!/bin/bash
# Submits all shards, and a merge that runs if all of them have succeeded. Written by `scanbench submit slurm`.
#
# Once more, it makes the shards that are missing.
set -eu

cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
mkdir -p logs
shards=$(sbatch --parsable shards.sh)
# A merge whose shards have failed is cancelled; else it would wait for ever.
merge=$(sbatch --parsable --dependency="afterok:${shards%%;*}" --kill-on-invalid-dep=yes merge.sh)
echo "shards: job ${shards%%;*}, merge: job ${merge%%;*}, merged run: $PWD/{{run}}"
