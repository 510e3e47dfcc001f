#!/bin/bash
# Each task of the array makes one shard. Written by `scanbench submit slurm`; submit.sh hands it to Slurm.
#SBATCH --job-name={{name}}
#SBATCH --array=1-{{tasks}}
#SBATCH --output=logs/shard-%a.txt
#SBATCH --open-mode=append
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
{{limits}}set -eu

cd -- {{workplace}}
shard={{shards}}/$(printf {{shard}} "$SLURM_ARRAY_TASK_ID")
if [ -e "$shard/manifest.json" ]; then
    echo "$shard is done"
    exit
fi
# In the place of the shell, so that the notice before the time limit reaches it.
exec {{program}} {{verb}} --shard "$SLURM_ARRAY_TASK_ID/{{n_shards}}" {{words}}
