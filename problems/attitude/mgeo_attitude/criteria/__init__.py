"""What designs are judged by: objectives and limits of a run, flown exactly or over flights."""
