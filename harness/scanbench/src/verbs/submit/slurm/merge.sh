#!/bin/bash
# Puts the shards together. Written by `scanbench submit slurm`; submit.sh lets it wait for all of them.
#SBATCH --job-name={{name}}-merge
#SBATCH --output=logs/merge.txt
#SBATCH --open-mode=append
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
{{limits}}set -eu

cd -- {{workplace}}
exec {{program}} merge {{shards}}/shard-*-of-{{n_shards}} -o {{run}} --overwrite
