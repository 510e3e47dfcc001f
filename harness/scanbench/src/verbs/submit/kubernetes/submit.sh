#!/bin/bash
# Runs all shards, waits, and merges them if all have succeeded. Written by `scanbench submit kubernetes`.
#
# Once more, it goes on waiting. To make shards that failed again: kubectl delete job {{name}}-shards, and run it again.
set -eu

cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
conditions='{.status.conditions[?(@.status=="True")].type}'

# Waits until the job $1 has ended, and fails if it failed. It fails as well where there is no such job.
wait_for() {
    while ended=$(kubectl get "job/$1" -o "jsonpath=$conditions"); do
        case " $ended " in
        *" Complete "*) return 0 ;;
        *" Failed "*)
            echo "$1 failed; kubectl describe job $1 says which pods did" >&2
            return 1
            ;;
        esac
        sleep 10
    done
    return 1
}

kubectl apply -f shards.yaml
wait_for {{name}}-shards
kubectl apply -f merge.yaml
wait_for {{name}}-merge
echo "merged run: {{run}} in the volume of the claim {{claim}}"
